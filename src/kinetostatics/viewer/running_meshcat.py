"""Drawing of a scene into a running meshcat, with heading, legend, camera and light; connection to meshcat's server.

Meshcat's content is a tree of nodes. Poses of stations are placements (4, 4) of coordinate systems that move with the robot.
"""

from __future__ import annotations

import base64
import contextlib
import io
import subprocess
import sys
from collections.abc import Callable, Iterator
from html import escape
from typing import NamedTuple
from uuid import uuid4
from weakref import WeakKeyDictionary

import numpy as np
import zmq
from meshcat import geometry
from meshcat.animation import Animation
from meshcat.commands import SetAnimation
from meshcat.path import Path
from meshcat.transformations import translation_matrix
from meshcat.visualizer import ViewerWindow, Visualizer

from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.math.arrays import Array
from kinetostatics.viewer.description import AXES, FIELD_OF_VIEW, HIDDEN, LIGHT, MARK, RESTING, Mesh, Scene
from kinetostatics.viewer.shapes import Surface, arrow, ball, frames_along, joined
from kinetostatics.viewer.still import HEIGHT, INK, WIDTH, Still, heading, image, legend, number

#: Folders of the scene's roots.
ROOTS = {"Rest": "resting", "Deformed": "deformed", "Base": "base"}
#: Properties of the robot at rest, which is hidden where it coincides with the deformed robot, as in the page.
BEHIND = {"polygonOffset": True, "polygonOffsetFactor": 2, "polygonOffsetUnits": 8}
#: Node of the camera.
CAMERA = "/Cameras/default/rotated/<object>"
#: Distance of the camera's near plane, as a part of the robot's size.
NEAREST = 0.01
#: Colours of the axes x, y and z, as in the page.
AXIS_COLOURS = ("#d62728", "#2ca02c", "#1f77b4")
#: Factors of the displacements in the frames of the animation, from deformed to rest and back; frames per second.
SWING, RATE = 0.5 + 0.5 * np.cos(np.linspace(0, 2 * np.pi, 25)), 10
#: Number of repetitions of the animation after the first drawing.
REPETITIONS = 3
#: Height of text in the scene [pixels], in a picture of height HEIGHT.
WORDS = 18

#: Nodes of drawn robots, by window: the camera is set at the first drawing only.
_SEEN: WeakKeyDictionary[ViewerWindow, set[str]] = WeakKeyDictionary()


def draw(scene: Scene, visualizer: Visualizer, node: str) -> Visualizer:
    """Replace the content of a node by a scene's first pose, and return the visualizer at the node.

    Heading and legend are in front of the camera. The first drawing at a node also sets camera, light and background, and plays
    the motion between the undeformed and the deformed robot.
    """
    if not isinstance(visualizer, Visualizer):
        raise ArgumentError(
            f"visualizer is a {type(visualizer).__name__}; it must be a meshcat.Visualizer (that of Pinocchio's "
            "MeshcatVisualizer is its .viewer)"
        )
    if not isinstance(node, str) or not all(node.split("/")):
        raise ArgumentError(f"node is {node!r}; it must be names joined by '/', such as 'kinetostatics/3rps'")
    root = visualizer[node]
    root.delete()
    seen = _SEEN.setdefault(root.window, set())
    _Drawing(Still(scene), root).draw(first=root.path.lower() not in seen)
    seen.add(root.path.lower())
    return root


class _Drawing:
    def __init__(self, still: Still, root: Visualizer) -> None:
        self.still, self.scene, self.root = still, still.scene, root
        self.frames = [still.moved(part) for part in SWING]
        self.animation = Animation(default_framerate=RATE)

    def draw(self, first: bool) -> None:
        for mesh in self.scene.meshes:
            for root in mesh.roots:
                self._mesh(mesh, root)
        self._arrows()
        self._mark()
        for name, station, label in self.scene.frames:
            node = self._node(f"frames/{name}")
            surface, colours = _axes(AXES * self.scene.size)
            node.set_object(
                geometry.TriangularMeshGeometry(surface.vertices, surface.faces, colours),
                geometry.MeshPhongMaterial(vertexColors=True, depthTest=False, transparent=True),
            )
            self._moving(node, _pose_of(station))
            self._label(f"{name}", label, _point_of(station))
        for path, station, text in self.scene.labels:
            self._label(path, text, _point_of(station))
        lines, square = self.still.floor()
        self._node("floor").set_object(
            geometry.LineSegments(geometry.PointsGeometry(lines.T.astype(np.float32)), geometry.LineBasicMaterial(color=0xDDE1E6))
        )
        above, below = self._overlay(square)
        if first:
            self._stage(above, below)
        if self.still.largest[0]:
            self.root.window.send(_Swing(self.animation, self._node("animation").path, first))

    def _node(self, path: str) -> Visualizer:
        """Return the visualizer at a path below the robot's node, without empty names, which mean the root in meshcat."""
        return self.root["/".join(filter(None, path.split("/")))]

    def _moving(self, node: Visualizer, placed: Callable[[Array], Array]) -> None:
        """Set a node's transform, now and in the animation; ``placed`` computes it from the poses (n, 4, 4) of all stations."""
        node.set_transform(placed(self.still.deformed))
        for frame, poses in enumerate(self.frames):
            self.animation.at_frame(node, frame).set_transform(placed(poses))

    def _mesh(self, mesh: Mesh, root: str) -> None:
        node, colour = self._node(f"{ROOTS[root]}/{mesh.path}"), self.still.look(mesh, root)
        look: dict[str, object] = {"shininess": 12, "specular": 0x222222}
        look |= {"color": _integer(colour)} if isinstance(colour, str) else {"color": 0xFFFFFF, "vertexColors": True}
        if root == "Rest":
            look |= {"opacity": RESTING[1], "depthWrite": False, "shininess": 5, "side": 0, **BEHIND}  # front faces only
        station, colours = mesh.station, None if isinstance(colour, str) else colour
        vertices = mesh.surface.vertices if isinstance(station, int) else self.still.vertices(mesh, root)
        surface = geometry.TriangularMeshGeometry(vertices, mesh.surface.faces, colours)
        if root == "Deformed" and not isinstance(station, int):
            surface = _Bent(surface, self.still.vertices(mesh, "Rest"))
            for frame, part in enumerate(SWING):
                self.animation.at_frame(node["<object>"], frame).set_property("morphTargetInfluences[0]", "number", 1 - part)
        node.set_object(surface, geometry.MeshPhongMaterial(**look))
        if isinstance(station, int) and root == "Deformed":
            self._moving(node, _pose_of(station))
        elif isinstance(station, int):
            node.set_transform(self.still.rest[station])

    def _arrows(self) -> None:
        for still_arrow in self.still.arrows:
            path = f"{still_arrow.arrow.group}/{still_arrow.arrow.name}"
            node, colour = self._node(f"forces/{path}"), _integer(still_arrow.colour)
            surface = geometry.TriangularMeshGeometry(still_arrow.surface.vertices, still_arrow.surface.faces)
            node.set_object(surface, geometry.MeshPhongMaterial(color=colour, shininess=12))
            inside = geometry.MeshBasicMaterial(color=colour, opacity=0.28, depthTest=False, depthWrite=False)
            node["inside"].set_object(surface, inside)
            self._moving(node, still_arrow.placed)
            self._label(path, still_arrow.text, still_arrow.place_of_label, still_arrow.colour)
        for group in HIDDEN:
            if any(still_arrow.arrow.group == group for still_arrow in self.still.arrows):
                self._node(f"forces/{group}").set_property("visible", False)
                self._node(f"labels/{group}").set_property("visible", False)

    def _mark(self) -> None:
        value, mesh, vertex = self.still.largest
        if mesh is not None:
            node, unit = self._node("largest"), self.scene.facts.displacement
            dot = geometry.MeshBasicMaterial(color=_integer(MARK), depthTest=False, transparent=True)
            node.set_object(geometry.Sphere(0.007 * self.scene.size), dot)
            words = f"largest {number(value / unit.factor)} {unit.unit}"

            def place(poses: Array) -> Array:
                return np.asarray(self.still.vertices_at(mesh, poses)[vertex])

            self._moving(node, lambda poses: np.asarray(translation_matrix(place(poses))))
            self._label("largest", words, place, MARK)

    def _label(self, path: str, text: str, placed: Callable[[Array], Array], colour: str = INK) -> None:
        """Add text of constant size that faces the camera; ``placed`` computes its position from the poses of all stations."""
        node, width = self._node(f"labels/{path}"), 40 + 10 * len(text)
        words = f'<text x="{width / 2}" y="{WORDS}" font-weight="600" text-anchor="middle" fill="{colour}">{escape(text)}</text>'
        pixel = 2 * np.tan(np.radians(FIELD_OF_VIEW) / 2) / HEIGHT
        node.set_object(_sprite(image([words], width, 3 * WORDS), width * pixel, 3 * WORDS * pixel, sizeAttenuation=False))
        self._moving(node, lambda poses: np.asarray(translation_matrix(placed(poses))))

    def _overlay(self, square: float) -> tuple[float, float]:
        """Draw heading and legend in front of the camera, and return their heights as parts of the picture's height."""
        (above, top), (below, bottom) = heading(self.still), legend(self.still, square)
        depth = 5 * NEAREST * self.scene.size
        half = depth * np.tan(np.radians(FIELD_OF_VIEW) / 2)
        before = self.root[f"{CAMERA}/kinetostatics"]
        for name, text, height, side in (("heading", above, top, 1), ("legend", below, bottom, -1)):
            before[name].set_object(_sprite(text, 2 * half * WIDTH / HEIGHT, 2 * half * height / HEIGHT))
            before[name].set_transform(translation_matrix([0, side * half * (1 - height / HEIGHT), -depth]))
        return top / HEIGHT, bottom / HEIGHT

    def _stage(self, above: float, below: float) -> None:
        """Set camera, light and background; ``above`` and ``below`` are the heights that :meth:`_overlay` returns."""
        target, position = self.still.camera(WIDTH / HEIGHT, above, below)
        turned = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])  # z up in the scene, y in the window
        # The camera turns about the window's origin: the scene is shifted there, and the camera's node back.
        self.root["/"].set_transform(turned @ translation_matrix(-target))
        self.root["/Cameras/default"].set_transform(translation_matrix(target))
        eye = self.root[CAMERA]
        eye.set_property("position", (turned[:3, :3] @ position).tolist())
        eye.set_property("fov", FIELD_OF_VIEW)
        eye.set_property("near", NEAREST * self.scene.size)
        eye.set_property("far", 100 * self.scene.size)
        for name in ("Grid", "Axes", "Lights/PointLightNegativeX", "Lights/PointLightPositiveX"):
            self.root[f"/{name}"].set_property("visible", False)
        for end in ("top_color", "bottom_color"):
            self.root["/Background"].set_property(end, [1, 1, 1])
        light = self.root["/Lights/SpotLight"]  # far away, as in the page
        light.set_property("visible", True)
        light["<object>"].set_property("intensity", LIGHT["intensity"])
        light["<object>"].set_property("position", (100 * self.scene.size * np.array(LIGHT["from"])).tolist())


class _Bent:
    """A surface with a morph target: with ``morphTargetInfluences[0]`` = 1 its vertices are at ``others`` (n, 3)."""

    def __init__(self, surface: geometry.TriangularMeshGeometry, others: Array) -> None:
        self.surface, self.others = surface, others
        self.uuid, self.intrinsic_transform = surface.uuid, surface.intrinsic_transform

    def lower_in_object(self, data: dict[str, list[dict[str, dict[str, object]]]]) -> str:
        """Write the surface into a command for meshcat."""
        self.surface.lower_in_object(data)
        data["geometries"][-1]["data"]["morphAttributes"] = {"position": [geometry.pack_numpy_array(self.others.T)]}
        return str(self.uuid)


class _Svg(NamedTuple):
    """An SVG image."""

    text: str
    uuid: str

    def lower_in_object(self, data: dict[str, list[dict[str, str]]]) -> str:
        """Write the image into a command for meshcat."""
        address = "data:image/svg+xml;base64," + base64.b64encode(self.text.encode()).decode("ascii")
        data.setdefault("images", []).append({"uuid": self.uuid, "url": address})
        return self.uuid


class _Swing(NamedTuple):
    """An animation at a separate node, which meshcat sends to a new window after the nodes that the animation moves."""

    animation: Animation
    path: Path
    play: bool

    def lower(self) -> dict[str, object]:
        """Return the animation as a command for meshcat."""
        return {**SetAnimation(self.animation, self.play, REPETITIONS).lower(), "path": self.path.lower()}


def _pose_of(station: int) -> Callable[[Array], Array]:
    return lambda poses: poses[station]


def _point_of(station: int) -> Callable[[Array], Array]:
    return lambda poses: poses[station][:3, 3]


def _sprite(text: str, width: float, height: float, **look: object) -> geometry.Object:
    """Return an SVG image that faces the camera, as a sprite of three.js; meshcat has no class for sprites."""
    texture = geometry.GenericTexture(
        {"wrap": [1001, 1001], "repeat": [1, 1], "minFilter": 1006, "image": _Svg(text, str(uuid4()))}
    )
    material = geometry.GenericMaterial(map=texture, transparent=True, depthTest=False, depthWrite=False, **look)
    material._type = "SpriteMaterial"
    sprite = geometry.Object(geometry.Ellipsoid([width, height, 1.0]), material)  # a sprite uses only its scale
    sprite._type = "Sprite"
    return sprite


def _axes(size: float) -> tuple[Surface, Array]:
    """Return arrows along x, y and z, with a ball at the origin, and the colours (n, 3) of their vertices."""
    along = arrow(size, 0.025 * size, 1)
    surfaces = [along.transformed(frames_along(axis[None])[0]) for axis in np.eye(3)] + [ball(0.05 * size)]
    colours = [np.array([_integer(colour) >> shift & 255 for shift in (16, 8, 0)]) / 255 for colour in (*AXIS_COLOURS, INK)]
    shades = [np.tile(colour, (len(surface.vertices), 1)) for surface, colour in zip(surfaces, colours, strict=True)]
    return joined(surfaces), np.concatenate(shades)


def _integer(colour: str) -> int:
    """Return "#rrggbb" as an integer."""
    return int(colour[1:], 16)


#: Timeout of a server's response [ms].
PATIENCE = 10_000
#: Program that runs meshcat's server on the local address only; by default the server's page is reachable from all networks.
LOCAL_SERVER = """
import functools, tornado.web
tornado.web.Application.listen = functools.partialmethod(tornado.web.Application.listen, address="127.0.0.1")
from meshcat.servers.zmqserver import main
main()
"""


@contextlib.contextmanager
def connected(url: str | None) -> Iterator[Visualizer]:
    """Yield the visualizer of the meshcat-server at a ZeroMQ address, or of a new local server that ends with the context.

    Raises:
        KinetostaticsError: no server answers, or none can be started.
    """
    with contextlib.ExitStack() as stack:
        server, address = (None, url) if url else stack.enter_context(_local_server())
        with contextlib.redirect_stdout(io.StringIO()):  # it prints its address
            visualizer = _reached(address)
        visualizer.window.server_proc = server
        try:
            yield visualizer
        except zmq.ZMQError as error:
            raise KinetostaticsError(f"the meshcat-server does not answer any more: {error}") from None
        finally:  # a collected context would wait for its sockets, which may be collected after it
            visualizer.window.zmq_socket.context.destroy(linger=0)


@contextlib.contextmanager
def _local_server() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a server; yield its process and its ZeroMQ address."""
    command = [sys.executable, "-u", "-c", LOCAL_SERVER]
    server = subprocess.Popen(  # in a separate session, so that Ctrl+C does not reach it
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        assert server.stdout is not None
        answer = server.stdout.readline().strip()
        if not answer.startswith("zmq_url="):
            raise KinetostaticsError("meshcat's server does not start; for the reason, run python -m meshcat.servers.zmqserver")
        yield server, answer.removeprefix("zmq_url=")
    finally:
        server.terminate()
        server.wait()


def _reached(url: str) -> Visualizer:
    """Return the visualizer of a running server, with timeouts for its sockets."""
    limits = {zmq.RCVTIMEO: PATIENCE, zmq.SNDTIMEO: PATIENCE, zmq.LINGER: 0}
    before = ViewerWindow.context
    ViewerWindow.context = context = zmq.Context()
    for option, value in limits.items():
        context.setsockopt(option, value)
    try:
        return Visualizer(zmq_url=url)
    except zmq.ZMQError:
        context.destroy(linger=0)
        raise ArgumentError(
            f"no meshcat-server answers at {url!r}; give the zmq_url that it printed, such as tcp://127.0.0.1:6000"
        ) from None
    finally:
        ViewerWindow.context = before
