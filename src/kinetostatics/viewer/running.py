"""Drawing of a scene in a running meshcat, under a separate path."""

from __future__ import annotations

import contextlib
import io
import math
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import zmq
from meshcat import geometry
from meshcat.visualizer import ViewerWindow, Visualizer

from kinetostatics.exceptions import ArgumentError, KinetostaticsError
from kinetostatics.math.arrays import Array
from kinetostatics.viewer.description import AXES, HIDDEN, RAMP, RESTING, Arrow, Mesh, Scene
from kinetostatics.viewer.shapes import arrow as arrow_surface
from kinetostatics.viewer.shapes import frames_along

#: Folders of the scene's roots.
ROOTS = {"Rest": "resting", "Deformed": "deformed", "Base": "base"}
#: How long a server may take to answer [ms].
PATIENCE = 10_000
#: Runs meshcat's server on this machine only: by itself it takes commands from here alone, but shows the scene to every network.
LOCAL_SERVER = """
import functools, tornado.web
tornado.web.Application.listen = functools.partialmethod(tornado.web.Application.listen, address="127.0.0.1")
from meshcat.servers.zmqserver import main
main()
"""


def draw(scene: Scene, visualizer: Visualizer, node: str) -> Visualizer:
    """Draw a scene's first frame at a node, in place of what stood there; nothing else is touched.

    Args:
        scene: of one pose.
        visualizer: a running one.
        node: names joined by '/', below the visualizer's own.

    Returns:
        The visualizer at the node.

    Raises:
        ArgumentError: ``visualizer`` is something else, or ``node`` would lead out of it.
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
    _Drawing(scene, root).draw()
    return root


@contextlib.contextmanager
def connected(url: str | None) -> Iterator[Visualizer]:
    """Give the visualizer of the meshcat-server at a ZeroMQ address, or of a new one on this machine, which ends with the block.

    Raises:
        KinetostaticsError: no server answers, or none can be started.
    """
    with contextlib.ExitStack() as stack:
        server, address = (None, url) if url else stack.enter_context(_local_server())
        with contextlib.redirect_stdout(io.StringIO()):  # it prints its address, which is for the caller to tell
            visualizer = _reached(address)
        visualizer.window.server_proc = server
        try:
            yield visualizer
        except zmq.ZMQError as error:
            raise KinetostaticsError(f"the meshcat-server does not answer any more: {error}") from None


@contextlib.contextmanager
def _local_server() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a server, and give its process and its ZeroMQ address."""
    command = [sys.executable, "-u", "-c", LOCAL_SERVER]
    server = subprocess.Popen(  # in a session of its own, so that Ctrl+C ends it by us
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        assert server.stdout is not None
        answer = server.stdout.readline().strip()
        if not answer.startswith("zmq_url="):
            raise KinetostaticsError("meshcat's server does not start; python -m meshcat.servers.zmqserver says why")
        yield server, answer.removeprefix("zmq_url=")
    finally:
        server.terminate()
        server.wait()


def _reached(url: str) -> Visualizer:
    """Return the visualizer of a running server, whose sockets do not wait for ever."""
    limits = {zmq.RCVTIMEO: PATIENCE, zmq.SNDTIMEO: PATIENCE, zmq.LINGER: 0}
    before = ViewerWindow.context
    ViewerWindow.context = zmq.Context()
    for option, value in limits.items():
        ViewerWindow.context.setsockopt(option, value)
    try:
        return Visualizer(zmq_url=url)
    except zmq.ZMQError:
        raise ArgumentError(
            f"no meshcat-server answers at {url!r}; give the zmq_url that it printed, such as tcp://127.0.0.1:6000"
        ) from None
    finally:
        ViewerWindow.context = before


class _Drawing:
    def __init__(self, scene: Scene, root: Visualizer) -> None:
        self.scene, self.root = scene, root
        self.rest = np.stack([rest[0] for rest in scene.stations.rest])
        self.deformed = scene.stations.moved(0, scene.exaggeration)
        self.twists = scene.stations.all_twists[0].sum(axis=1)
        self.largest = float(np.linalg.norm(self.twists[:, :3], axis=-1).max()) or 1.0

    def draw(self) -> None:
        for mesh in self.scene.meshes:
            for root in mesh.roots:
                self._mesh(mesh, root)
        groups = {self._arrow(*item) for item in self.scene.scaled_arrows()}
        for group in HIDDEN:
            if group in groups:
                self._node(f"forces/{group}").set_property("visible", False)
        for name, station, label in self.scene.frames:
            node = self._node(f"frames/{name}")
            axes = geometry.triad(AXES * self.scene.size)
            axes.material.properties = {"depthTest": False}  # or they would hide in the bodies they belong to
            node.set_object(axes)
            node.set_transform(self.deformed[station])
            self._label(node["label"], label, np.full(3, 0.03 * self.scene.size))
        for path, station, text in self.scene.labels:
            self._label(self._node(f"labels/{path}"), text, self.deformed[station, :3, 3])

    def _node(self, path: str) -> Visualizer:
        """Return the visualizer at a path below ours; two slashes in a link's name would lead to the top of the tree."""
        return self.root["/".join(filter(None, path.split("/")))]

    def _mesh(self, mesh: Mesh, root: str) -> None:
        vertices, colours = mesh.surface.vertices, None
        poses = self.deformed if root == "Deformed" else self.rest
        look: dict[str, object] = {"color": 0xFFFFFF, "vertexColors": True, "shininess": 12, "specular": 0x222222}
        if root == "Rest":
            look = {"color": _integer(RESTING[0]), "opacity": RESTING[1], "depthWrite": False, "shininess": 5}
        elif not isinstance(mesh.colour, str):
            colours = mesh.colour
        elif mesh.colour == "deflection":
            colours = self._colours(mesh)
        else:
            look.update(color=_integer(mesh.colour), vertexColors=False)
        node = self._node(f"{ROOTS[root]}/{mesh.path}")
        rigid = isinstance(mesh.station, int)
        if not rigid:
            at = poses[mesh.station]
            vertices = np.einsum("nij,nj->ni", at[:, :3, :3], vertices) + at[:, :3, 3]
        surface = geometry.TriangularMeshGeometry(vertices, mesh.surface.faces, colours)
        node.set_object(surface, geometry.MeshPhongMaterial(**look))
        if rigid:
            node.set_transform(poses[mesh.station])

    def _colours(self, mesh: Mesh) -> Array:
        """Return the colour (n, 3) of every vertex by its true displacement u + θ × r."""
        station = np.broadcast_to(mesh.station, len(mesh.surface.vertices))
        arms = np.einsum("nij,nj->ni", self.rest[station, :3, :3], mesh.surface.vertices)
        twists = self.twists[station]
        lengths = np.linalg.norm(twists[:, :3] + np.cross(twists[:, 3:], arms), axis=-1) / self.largest
        steps = np.linspace(0, 1, len(RAMP))
        ramp = np.array([[int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5)] for colour in RAMP])
        return np.column_stack([np.interp(lengths, steps, ramp[:, channel]) for channel in range(3)])

    def _arrow(self, arrow: Arrow, metres_per_unit: float, radius: float, colour: str) -> str | None:
        """Draw an arrow and return its group; one that is too short to see is left out."""
        vector = arrow.vector[0].sum(axis=0)
        size = float(np.linalg.norm(vector))
        length = size * metres_per_unit
        if length <= 0.2 * radius:
            return None
        value = -size if arrow.positive is not None and arrow.positive[0] @ vector < 0 else size
        if isinstance(arrow.anchor, str):
            inwards = arrow.anchor == "tip"
        else:
            inwards = bool(arrow.anchor[0] @ vector < -0.1 * np.linalg.norm(arrow.anchor[0]) * size)
        at = self.deformed[arrow.station]
        frame = frames_along(vector[None])[0]
        frame[:3, 3] = at[:3, 3] + at[:3, :3] @ arrow.offset - inwards * metres_per_unit * vector
        surface = arrow_surface(length, radius, 1 if arrow.kind == "force" else 2)
        node = self._node(f"forces/{arrow.group}/{arrow.name}")
        node.set_object(
            geometry.TriangularMeshGeometry(surface.vertices, surface.faces),
            geometry.MeshPhongMaterial(color=_integer(colour), shininess=12),
        )
        node.set_transform(frame)
        beyond = 0.03 * self.scene.size
        end = -beyond if inwards else length + beyond  # the label stands at the free end
        self._label(node["label"], f"{arrow.label} {_number(value)} {arrow.unit}", np.array([0, 0, end]))
        return arrow.group

    def _label(self, node: Visualizer, text: str, place: Array) -> None:
        """Write words that face the camera: a sprite of three.js, for which meshcat has no class, with its text texture."""
        words = geometry.GenericTexture({"type": "_text", "text": text, "font_size": 36, "font_face": "sans-serif"})
        material = geometry.GenericMaterial(map=words, transparent=True, depthTest=False)
        material._type = "SpriteMaterial"
        scale = geometry.Ellipsoid([0.45 * self.scene.size] * 3)  # of which a sprite takes the scale alone
        sprite = geometry.Object(scale, material)
        sprite._type = "Sprite"
        node.set_object(sprite)
        matrix = np.eye(4)
        matrix[:3, 3] = place
        node.set_transform(matrix)


def _integer(colour: str) -> int:
    """Return "#rrggbb" as meshcat wants it."""
    return int(colour[1:], 16)


def _number(value: float) -> str:
    """Return three digits, as in the page."""
    digits = f"{value:.2e}" if abs(value) >= 1e6 else f"{value:.0f}" if abs(value) >= 100 else f"{value:#.3g}"
    return digits.replace("-", "−") if math.isfinite(value) else "–"
