"""Content of a page as plain data: stations, and the surfaces, arrows, coordinate systems and labels attached to them.

A station is a coordinate system that moves with the robot. A contribution is the displacement, or force, due to one load or
weight; its share is the factor of a slider by which the page multiplies it. ``plain`` methods return data for JSON.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.rotations import exponential, quaternion_of_matrix
from kinetostatics.viewer.cards import Card, FrameFacts, quantities_of
from kinetostatics.viewer.packing import EXACT, Packing, packed, packed_indices
from kinetostatics.viewer.shapes import Surface
from kinetostatics.viewer.single_poses import DrawnMode


class Stations:
    """Coordinate systems that move with the robot.

    At each of F poses of a path, a station has a placement at rest (undeformed) and a small twist by each of K contributions.

    Attributes:
        frames: number of poses of the path, F.
        contribution_names: labels of the contributions.
        rest: for each station, (F, 4, 4) placements at rest.
        twists: for each station, (F, K, 6) twists at its origin, world axes [m, rad].
    """

    def __init__(self, frames: int, contribution_names: tuple[str, ...]) -> None:
        self.frames, self.contribution_names = frames, contribution_names
        self.rest: list[Array] = []
        self.twists: list[Array] = []

    def add(self, placements: Array, twist: Array | None = None) -> int:
        """Add a station and return its index.

        Args:
            placements: (F, 4, 4) placements at rest; or (F, 3) origins [m], with world axes.
            twist: (F, K, 6) twists at its origin, world axes [m, rad]; None: it does not move.
        """
        if placements.ndim == 2:
            points, placements = placements, zeros_for((self.frames, 4, 4), placements)
            placements[:] = np.eye(4)
            placements[:, :3, 3] = points
        self.rest.append(placements)
        self.twists.append(np.zeros((self.frames, len(self.contribution_names), 6)) if twist is None else twist)
        return len(self.rest) - 1

    def add_all(self, placements: Array, twists: Array) -> int:
        """Add n stations with ``placements`` (F, n, 4, 4) and ``twists`` (F, K, n, 6); return the index of the first."""
        self.rest.extend(np.swapaxes(placements, 0, 1))
        self.twists.extend(np.moveaxis(twists, 2, 0))
        return len(self.rest) - placements.shape[1]

    @property
    def poses(self) -> Array:
        """(F, n, 7) origins [m] and quaternions (x, y, z, w) of the n stations at rest."""
        placements = np.stack(self.rest, axis=1)
        rotation = np.moveaxis(placements[..., :3, :3], (-2, -1), (0, 1))
        return np.concatenate([placements[..., :3, 3], np.moveaxis(quaternion_of_matrix(rotation), 0, -1)], axis=-1)

    @property
    def all_twists(self) -> Array:
        """(F, n, K, 6) [m, rad]."""
        return np.stack(self.twists, axis=1)

    def moved(self, frame: int, exaggeration: float, shares: Array) -> Array:
        """Return the deformed placements (n, 4, 4) at the pose with index ``frame``, for shares (K,), as ``motion.js`` does."""
        poses = np.stack([placements[frame] for placements in self.rest])
        twists = exaggeration * np.einsum("nki,k->ni", self.all_twists[frame], shares)
        poses[:, :3, 3] += twists[:, :3]
        poses[:, :3, :3] = np.moveaxis(exponential(twists[:, 3:].T), -1, 0) @ poses[:, :3, :3]
        return poses


#: Number of vertices from which a rigid mesh is rounded, and the bits to which it is: 0.03 mm of 0.5 m.
MANY, MESH_BITS = 1000, 14


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface in meshcat's tree.

    Attributes:
        path: path of its nodes below each of ``roots``.
        surface: triangles in the axes of their stations.
        station: index of its station, or (n,) indices for all vertices.
        roots: top nodes under which it is drawn: ``Rest`` (pale, undeformed), ``Deformed`` (solid, deformed), ``Base`` (solid,
            undeformed).
        colour: "deflection", "#rrggbb", or (n, 3) colours of the vertices, 0 to 1.
        recovery: displacements (n, 3, 6 s) by unit twists of ``station`` and the s − 1 next ones, in its axes; None: as stations.
    """

    path: str
    surface: Surface
    station: int | NDArray[np.int64]
    roots: tuple[str, ...]
    colour: str | Array = "deflection"
    recovery: Array | None = None

    def displacements(self, rotation: Array, twists: Array) -> Array:
        """Return the displacements (n, 3) by :attr:`recovery`, for rotation matrices and twists (…, 6) of all stations."""
        assert self.recovery is not None
        first = int(np.min(self.station))
        axes, count = rotation[first], self.recovery.shape[2] // 6
        return np.asarray(self.recovery @ (twists[first : first + count].reshape(-1, 3) @ axes).ravel() @ axes.T)

    @property
    def by_deflection(self) -> bool:
        return isinstance(self.colour, str) and self.colour == "deflection"

    def plain(self) -> dict[str, object]:
        colour = self.colour if isinstance(self.colour, str) else packed(np.round(255 * self.colour), "u1")
        return {
            "path": self.path, "roots": self.roots, "colour": colour, "per_vertex": not isinstance(self.colour, str),
            **self._plain_vertices(), "faces": packed_indices(self.surface.faces.ravel()),
            "station": self.station if isinstance(self.station, int) else packed(self.station, "<u4"),
            "recovery": None if self.recovery is None else packed(self.recovery, "<f4"),
        }  # fmt: skip

    def _plain_vertices(self) -> dict[str, object]:
        """Return the vertices; of large rigid meshes the different ones, rounded, and which of them each vertex is."""
        vertices = self.surface.vertices
        if not isinstance(self.station, int) or len(vertices) < MANY:
            return {"vertices": packed(vertices, "<f4"), "copies": None}
        _, first, copies = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
        rank = np.argsort(np.argsort(first))
        return {"vertices": Packing(MESH_BITS).path(vertices[np.sort(first)], 3), "copies": packed_indices(rank[copies.ravel()])}


@dataclass(frozen=True, eq=False)
class Arrow:
    """A force or couple.

    Attributes:
        group: kind of forces that the page shows or hides together, a key of :data:`GROUPS`.
        name: name of the node, as in the result.
        label: name in the picture.
        kind: "force" or "moment".
        station: index of the station to which it is attached.
        vector: (F, K + 1, 3) the vector by each contribution, and last the part that does not depend on the shares [N, N·m].
        offset: (3,) position relative to the station, in its axes [m].
        positive: (F, 3) positive direction, for the sign of the number in the label; None: the number is a magnitude.
        anchor: end of the arrow at the station, "tail" or "tip"; or (F, 3) outward direction: an arrow against this direction has
            its tip at the station, so that it lies outside the robot.
    """

    group: str
    name: str
    label: str
    kind: str
    station: int
    vector: Array
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    positive: Array | None = None
    anchor: str | Array = "tail"

    @property
    def unit(self) -> str:
        """Unit of the vector; empty for a free motion, whose magnitude is arbitrary."""
        if self.group == FREE_MOTION:
            return ""
        return "N" if self.kind == "force" else "N·m"

    @property
    def size(self) -> float:
        """Largest magnitude over all poses of the path, with all shares 1 [N, N·m]."""
        return float(np.linalg.norm(self.vector.sum(axis=1), axis=-1).max())

    def plain(self, metres_per_unit: float, radius: float, colour: str, packing: Packing) -> dict[str, object]:
        return {
            "path": f"Arrows/{self.group}/{self.name}", "label": self.label, "kind": self.kind, "station": self.station,
            "offset": self.offset, "vector": packing.path(self.vector, 3), "unit": self.unit,
            "positive": None if self.positive is None else packing.path(self.positive, 3),
            "anchor": self.anchor if isinstance(self.anchor, str) else None,
            "outward": None if isinstance(self.anchor, str) else packing.path(self.anchor, 3),
            "metres_per_unit": metres_per_unit, "radius": radius, "colour": colour,
        }  # fmt: skip


@dataclass
class Scene:
    """Content of a page; :meth:`plain` converts it to data for JSON.

    Attributes:
        title: heading.
        stations: coordinate systems that move with the robot.
        size: size of the robot [m].
        exaggeration: initial factor of displacements.
        readout: index of the station whose twist is shown in numbers.
        facts: pose, gravity, load and status for the heading; units of displacements.
        frames: (name, station, label) of each drawn coordinate system.
        labels: (path, station, text) of each further label.
        notes: warnings.
        cards: data of beams, joints, springs and point masses, by path of the mesh; a click on the mesh shows them.
        compare: a second scene on the same page.
        unloaded: whether the robot is drawn without loads; its contributions are then free motions or modes.
        modes: texts on the modes; the page shows one mode at a time.
        first: index of the mode shown first.
    """

    title: str
    stations: Stations
    size: float
    exaggeration: float
    readout: int
    facts: FrameFacts
    meshes: list[Mesh] = field(default_factory=list)
    arrows: list[Arrow] = field(default_factory=list)
    frames: list[tuple[str, int, str]] = field(default_factory=list)
    labels: list[tuple[str, int, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    cards: dict[str, Card] = field(default_factory=dict)
    compare: Scene | None = None
    unloaded: bool = False
    modes: list[DrawnMode] = field(default_factory=list)
    first: int = 0

    @property
    def shares(self) -> Array:
        """(K,) initial shares: of a result all are 1; of free motions or modes, number ``first`` is 1 and the others are 0."""
        count = len(self.stations.contribution_names)
        return np.eye(1, count, self.first)[0] if self.unloaded else np.ones(count)

    def plain(self, packing: Packing = EXACT) -> dict[str, object]:
        """Return the scene, with arrays as base64; ``packing`` encodes arrays that change along a path."""
        e = self.exaggeration
        return {
            **self.moving(packing),
            **self.details(packing),
            "title": self.title,
            "unloaded": self.unloaded,
            "modes": [vars(mode) for mode in self.modes],
            "exaggeration": {"value": e, "min": min(1.0, e / 100), "max": max(100.0, e * 100)},
            "meshes": [mesh.plain() for mesh in self.meshes],
            "frames": [
                {"path": f"Frames/{name}", "station": station, "label": label, "size": AXES * self.size}
                for name, station, label in self.frames
            ],
            "labels": [{"path": f"Labels/{path}", "station": at, "text": text} for path, at, text in self.labels],
            "seconds": float(np.clip(0.12 * self.stations.frames, 2, 8)),
            "groups": GROUPS,
            "compare": None if self.compare is None else self.compare.plain(packing=packing),
            "size": self.size,
            "shares": self.shares.tolist(),
            "view": VIEW,
            "field_of_view": FIELD_OF_VIEW,
            "light": LIGHT,
            "unknown": UNKNOWN,
            "mark": MARK,
            "ramp": RAMP,
            "signed_ramp": SIGNED_RAMP,
            "resting": {"colour": RESTING[0], "opacity": RESTING[1]},
            "hidden": [f"Arrows/{group}" for group in HIDDEN],
        }  # fmt: skip

    def moving(self, packing: Packing = EXACT) -> dict[str, object]:
        """Return the entries of :meth:`plain` that depend on pose and load, except notes and cards."""
        stations = self.stations
        return {
            "contributions": stations.contribution_names,
            "readout": self.readout,
            "stations": {
                "count": len(stations.rest), "frames": stations.frames,
                "pose": packing.path(stations.poses, 7),
                "twist": packing.path(stations.all_twists, 6 * len(stations.contribution_names)),
            },
            "arrows": [arrow.plain(scale, r, colour, packing) for arrow, scale, r, colour in self.scaled_arrows()],
            "facts": self.facts.plain(),
            "units": self.facts.units(),
        }  # fmt: skip

    def details(self, packing: Packing = EXACT) -> dict[str, object]:
        """Return the entries of :meth:`plain` for notes, cards and quantities shown by colours."""
        return {
            "notes": self.notes,
            "cards": {path: card.plain(packing) for path, card in self.cards.items()},
            "quantities": [quantity.plain() for quantity in quantities_of(self.cards.values())],
        }

    def scaled_arrows(self) -> list[tuple[Arrow, float, float, str]]:
        """Return (arrow, scale [m/N, m/(N·m)], radius [m], colour) of every arrow.

        In each group all forces have one scale, and all couples have one scale. The length of the longest arrow of a scale is a
        fixed part of the robot's size.
        """
        longest: dict[tuple[str, str], float] = {}
        for arrow in self.arrows:
            key = (arrow.group, arrow.kind)
            longest[key] = max(longest.get(key, 0.0), arrow.size)
        scaled = []
        for arrow in self.arrows:
            most = longest[arrow.group, arrow.kind]
            scale = (0.26 if arrow.kind == "force" else 0.2) * self.size / most if most > 0 else 0.0
            scaled.append((arrow, scale, 0.0055 * self.size, COLOURS.get(arrow.group, "#475569")))
        return scaled


#: Initial direction from the robot to the camera, world axes.
VIEW = (1.5, -2.6, 1.1)
#: Vertical field of view of the camera [°]; direction to the light, and intensity of the light.
FIELD_OF_VIEW = 32
LIGHT = {"from": (1, -2, 4), "intensity": 0.45}
#: Colour of surfaces without the shown quantity, and of the mark at the largest value.
UNKNOWN, MARK = "#c3c9d1", "#e6007a"
#: Colours of displacements, from zero to the largest (viridis).
RAMP = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")
#: Colours of signed quantities, from the most negative to the most positive.
SIGNED_RAMP = ("#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f2f2f2", "#fddbc7", "#f4a582", "#d6604d", "#b2182b")
#: Colour and opacity of the robot at rest.
RESTING = ("#7f8fa6", 0.2)
#: Length of the axes of a coordinate system, as a part of the robot's size.
AXES = 0.16
#: Groups of arrows that are initially hidden.
HIDDEN = (
    "constraint forces",
    "constraint couples",
    "attached wrenches",
    "joints of networks",
    "axial forces in networks",
    "weights",
    "base reaction",
)
#: Group of the platform's free motions.
FREE_MOTION = "free motion"
#: Colour of each group of arrows.
COLOURS = {
    FREE_MOTION: "#b91c1c",
    "external load": "#1f2937",
    "spring forces": "#0f766e",
    "actuator forces": "#b91c1c",
    "constraint forces": "#c2570c",
    "constraint couples": "#7e22ce",
    "attached wrenches": "#a8327a",
    "joints of networks": "#c2570c",
    "axial forces in networks": "#0e7490",
    "weights": "#7c4a1e",
    "base reaction": "#15803d",
}
#: Explanation of the arrows of each group.
GROUPS = {
    FREE_MOTION: "How the platform can move with the actuators locked: translation of o, and rotation.",
    "external load": "Load on the platform at o, loads on links, the payload's weight.",
    "spring forces": "Force of a spring on the link at its end, before the robot deforms; towards the spring in tension.",
    "actuator forces": "Force or torque of an actuator, positive along its joint's positive direction.",
    "constraint forces": "Wrench of the platform on the limb: constraint wrench times intensity.",
    "constraint couples": "Wrench of the platform on the limb: constraint wrench times intensity.",
    "attached wrenches": "Wrench of the platform on the limb that balances the limb's weight at its passive joints.",
    "joints of networks": "Wrench of the platform on the limb at a joint.",
    "axial forces in networks": "Axial force at the platform end of a beam, tension positive.",
    "weights": "Weight, at the centre of mass.",
    "base reaction": "Wrench of the ground on the robot, about the base link's origin.",
}
