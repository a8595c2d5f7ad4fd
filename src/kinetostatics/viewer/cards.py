"""Numbers on a page, in the units of the report: heading, cards, and quantities shown by colours.

A card is the table of one beam, joint, spring or point mass that the page shows after a click on it. ``plain`` methods return
data for JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.numbers import (
    ANGLES,
    FORCE_KINDS,
    FORCES,
    LENGTHS,
    MASSES,
    MILLIMETRES,
    NOISE,
    PER_CENT,
    STRESSES,
    NumberFormat,
    Units,
    largest,
)
from kinetostatics.math.arrays import Array
from kinetostatics.reports.pose import actuator_coordinates, actuator_unit, facts_of, platform_coordinates
from kinetostatics.reports.result import noise_floor
from kinetostatics.results.parts import BeamResult
from kinetostatics.statics.link_loads import PAYLOAD
from kinetostatics.viewer.drawn_parts import DrawnJoint, DrawnSpring
from kinetostatics.viewer.drawn_poses import ShownPoses, about_point, loads_on_links
from kinetostatics.viewer.packing import Packing
from kinetostatics.viewer.single_poses import SinglePose


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """Heading of a page: pose, loads and status at each of the F poses of a path.

    Attributes:
        pose: (name, unit, values (F,) in this unit) of each platform coordinate.
        gravity: (F, 3) gravity, world axes [m/s²]; None for a pose without loads.
        load: (F, 6) load about o, world axes [N, N·m]; None for a pose without loads.
        on_links: (F, 6) loads on links about their points of application, world axes [N, N·m], by name.
        payload: mass (F,) [kg], centre of mass (F, 3) [m], and the link in whose frame the centre is given (None: o-xyz); None if
            there is no payload.
        status: (F,) texts that list the states of each pose, the most severe state first.
        displacement, rotation: number formats of displacements and rotations in the legend and in tables.
    """

    pose: list[tuple[str, str, Array]]
    gravity: Array | None
    load: Array | None
    on_links: dict[str, Array]
    payload: tuple[Array, Array, str | None] | None
    status: list[str]
    displacement: NumberFormat
    rotation: NumberFormat

    def lines(self, frame: int) -> list[tuple[str, str]]:
        """Return (title, text) of each line of the heading at the pose with index ``frame``; the last line is the status."""
        lines = []
        if self.pose:
            pose = (f"{name} {_rounded(values[frame])}{'' if unit == '°' else ' '}{unit}" for name, unit, values in self.pose)
            lines.append(("pose", ", ".join(pose)))
        if self.gravity is not None and self.load is not None:
            lines += [("gravity", f"{_vector(self.gravity[frame])} m/s²"), ("load at o", _wrench(self.load[frame]))]
        lines += [(name, _wrench(wrench[frame])) for name, wrench in self.on_links.items()]
        if self.payload is not None:
            mass, center, link = self.payload
            where = f"{_vector(1e3 * center[frame])} mm in the frame of {link or 'o'}"
            lines.append(("payload", f"{_short(mass[frame])} kg at {where}"))
        return [*lines, ("status", self.status[frame])]

    def plain(self) -> list[list[tuple[str, str]]]:
        return [self.lines(frame) for frame in range(len(self.status))]

    def units(self) -> dict[str, object]:
        return {"displacement": plain_scale(self.displacement), "rotation": plain_scale(self.rotation)}


def _rounded(value: float) -> str:
    """Return a coordinate [mm, °] with up to two decimals, without trailing zeros."""
    return f"{round(float(value), 2) + 0.0:.15g}".replace("-", "−")


def _short(value: float) -> str:
    """Return a load with up to five digits, without trailing zeros; magnitudes below 5e-6 are written as 0."""
    return f"{0.0 if abs(value) < 5e-6 else float(f'{value:.5g}'):.15g}".replace("-", "−")


def _vector(values: Array) -> str:
    return f"({', '.join(map(_short, values))})"


def _wrench(values: Array) -> str:
    return f"{_vector(values[:3])} N" + (f", {_vector(values[3:])} N·m" if np.any(values[3:]) else "")


def find_facts(poses: ShownPoses, all_twists: Array, size: float) -> FrameFacts:
    """Return the heading; ``all_twists`` (F, n, K, 6), the twists of all stations, determine the legend's unit."""
    result = poses.result
    pose = _coordinates(result.configuration, lambda values: poses.of_configuration(values, 0))
    status = [["OK"] for _ in range(poses.count)]
    for title, where, words in facts_of(result):
        for frame in np.flatnonzero(poses.take(where.astype(np.float64))):
            status[frame].insert(0, f"{title}, {words}")
    shift = float(np.linalg.norm(all_twists.sum(axis=2)[..., :3], axis=-1).max(initial=0.0))
    twists = poses.platform_twist[..., 3:]
    return FrameFacts(
        pose, poses.take(result.gravity), poses.take(result.load), wrenches_on_links(poses, size), _payload(poses),
        ["; ".join(words[: max(1, len(words) - 1)]) for words in status],
        NumberFormat.of(shift, LENGTHS, digits=4),
        NumberFormat.of([largest([twists]), largest([twists.sum(axis=1)])], ANGLES, digits=4),
    )  # fmt: skip


#: Heading without texts.
NO_FACTS = FrameFacts(
    [], None, None, {}, None, ["OK"], NumberFormat.of(0.0, LENGTHS, digits=4), NumberFormat.of(0.0, ANGLES, digits=4)
)


def facts_without_loads(poses: SinglePose) -> FrameFacts:
    """Return a heading without loads; it contains the platform's coordinates if the robot's loops are closed."""
    pose = [] if poses.configuration is None else _coordinates(poses.configuration, lambda values: values.reshape(1))
    return replace(NO_FACTS, pose=pose)


def _coordinates(configuration: Configuration, taken: Callable[[Array], Array]) -> list[tuple[str, str, Array]]:
    """Return (name, unit, values (F,)) of each platform coordinate; ``taken`` selects the drawn poses of an array."""
    coordinates = []
    for name, (values, ((unit, factor),), noise) in platform_coordinates(configuration).items():
        along = taken(values)
        coordinates.append((name, unit, np.where(np.abs(along) <= noise, 0.0, along) / factor))
    return coordinates


def wrenches_on_links(poses: ShownPoses, size: float) -> dict[str, Array]:
    """Return :attr:`FrameFacts.on_links`; ``size`` is the size of the drawn robot [m]."""
    wrenches: dict[str, Array] = {}
    for name, _, point, wrench in loads_on_links(poses, ("load",)):
        if name != PAYLOAD:  # the loaded end of a beam may change along the path
            wrenches[name] = wrenches.get(name, 0.0) + about_point(wrench, point, poses.o, size)
    return wrenches


def _payload(poses: ShownPoses) -> tuple[Array, Array, str | None] | None:
    payload = poses.result.payload
    if payload is None:
        return None
    mass, center = (np.asarray(value, dtype=np.float64) for value in (payload.mass, payload.center))
    return poses.of_configuration(mass, 0), poses.of_configuration(center, 1), payload.link


def plain_scale(scale: NumberFormat) -> dict[str, object]:
    return vars(scale)


@dataclass(frozen=True, eq=False)
class CardRow:
    """A row of a card: its title, the format of its numbers, and values (F,) or vectors (F, w) at all poses [SI]."""

    words: str
    scale: NumberFormat
    values: Array

    def plain(self, packing: Packing) -> dict[str, object]:
        width = np.size(self.values[0])
        return {
            "words": self.words, **plain_scale(self.scale), "width": width, "values": packing.path(self.values, width)
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Card:
    """Data of one beam, joint, spring or point mass.

    Attributes:
        kind: kind of the part, for example "beam".
        rows: titles and numbers.
        note: explanation of the numbers.
        first: index of the first of a beam's stations, which are points along its centre line.
        lines: quantities of a beam [SI]: (F, n) at its stations, or (F, 1) if constant along it. The keys are ``T`` (torque),
            ``M_y``, ``M_z`` (bending moments), ``V_y``, ``V_z`` (shear forces) and the keys of :class:`BeamQuantity`.
    """

    kind: str
    rows: list[CardRow]
    note: str
    first: int = 0
    lines: dict[str, Array] = field(default_factory=dict)

    def plain(self, packing: Packing) -> dict[str, object]:
        lines = {name: packing.path(values) for name, values in self.lines.items()}
        return {
            "kind": self.kind, "rows": [row.plain(packing) for row in self.rows], "note": self.note, "first": self.first,
            "lines": lines,
        }  # fmt: skip


@dataclass(frozen=True)
class BeamQuantity:
    """A quantity for colours of beams: key in :attr:`Card.lines`, title, format, largest magnitude [SI], whether it is signed."""

    key: str
    words: str
    scale: NumberFormat
    largest: float
    signed: bool = False

    def plain(self) -> dict[str, object]:
        return {
            "key": self.key, "words": self.words, **plain_scale(self.scale), "largest": self.largest, "signed": self.signed
        }  # fmt: skip


def quantities_of(cards: Iterable[Card]) -> list[BeamQuantity]:
    """Return the quantities known for at least one beam; stresses are known only for sections of known outline."""
    quantities = []
    for key, words, units, digits, signed in (
        ("stress", "von Mises stress", STRESSES, 4, False),
        ("axial", "axial force, tension positive", (("N", 1.0),), 5, True),
        ("euler", "N/N_Euler", PER_CENT, 3, False),
    ):
        values = [np.asarray(card.lines[key], dtype=np.float64) for card in cards if key in card.lines]
        finite = np.concatenate([np.abs(value[np.isfinite(value)]) for value in values] or [np.zeros(0)])
        if finite.size:
            form = NumberFormat.of(finite, units, digits=digits)
            quantities.append(BeamQuantity(key, words, form, float(finite.max()), signed))
    return quantities


#: Title of the row with the largest stress of a beam.
LARGEST_STRESS = "largest von Mises stress"


class Cards:
    """Builder of the cards of all beams, joints, springs and point masses of a result."""

    def __init__(self, poses: ShownPoses, joints: Sequence[DrawnJoint], springs: Sequence[DrawnSpring]) -> None:
        self.poses, self.result, self.joints, self.springs = poses, poses.result, joints, springs
        self.noise = noise_floor(self.result)
        self.actuators = actuator_coordinates(self.result.configuration)

    def all(self, meshes: Mapping[str, int]) -> dict[str, Card]:
        """Return the cards by paths of their meshes; ``meshes`` gives the first station of each mesh, by its path."""
        beams = {f"beams/{name}": beam for name, beam in self.result.beams.items()}
        rows = self._beam_rows(list(beams.values()))
        cards = {}
        for (path, beam), row in zip(beams.items(), rows, strict=True):
            cards[path] = self._beam(beam, row, meshes[path])
        for joint in self.joints:
            if joint.beam is None:
                cards[f"joints/{joint.name}"] = self._joint(joint)
        cards |= {f"springs/{spring.description.name}": self._spring(spring) for spring in self.springs}
        masses = [path.removeprefix("masses/") for path in meshes if path.startswith("masses/")]
        return cards | {f"masses/{name}": self._mass(name) for name in masses}

    def _spring(self, spring: DrawnSpring) -> Card:
        description, none = spring.description, np.zeros(self.poses.count)
        lengths = NumberFormat.of([*spring.length, description.free_length], MILLIMETRES)
        force = NumberFormat.of([*spring.tension, description.preload], FORCES)
        rows = [
            CardRow("force, tension positive", force, spring.tension), CardRow("length", lengths, spring.length),
            CardRow("free length", lengths, none + description.free_length),
            CardRow("force at the free length", force, none + description.preload),
            CardRow("stiffness", NumberFormat.of(description.stiffness, (("N/m", 1.0),)), none + description.stiffness),
        ]  # fmt: skip
        return Card(f"spring between {' and '.join(spring.links)}", rows, "At the pose, before the robot deforms.")

    def _mass(self, name: str) -> Card:
        mass = self.result.robot.description.links[name].mass
        return Card("mass at a point", [CardRow("mass", NumberFormat.of(mass, MASSES), np.full(self.poses.count, mass))], "")

    def _beam_rows(self, beams: list[BeamResult]) -> list[list[CardRow]]:
        """Return the rows of each beam; a quantity has one unit for all beams, as in the report's table."""
        take, noise = self.poses.take, self.noise
        axial = [take(beam.section_wrenches)[..., 0] for beam in beams]
        shifts = [np.linalg.norm(take(beam.deflections), axis=-1) for beam in beams]
        force, shift = noise.format("force", axial), noise.format("displacement", shifts)

        def scaled(values: ArrayLike, units: Units, digits: int = 5) -> NumberFormat:
            return NumberFormat.of(values, units, digits=digits)

        columns = [
            ("length", scaled([b.length for b in beams], MILLIMETRES), [take(b.length) for b in beams]),
            ("mass", scaled([b.mass for b in beams], MASSES), [take(b.mass) for b in beams]),
            ("axial force at the base end", force, [values[:, 0] for values in axial]),
            ("axial force at the platform end", force, [values[:, -1] for values in axial]),
            (LARGEST_STRESS, scaled([b.stress for b in beams], STRESSES, 4), [take(b.stress) for b in beams]),
            ("N/N_Euler", scaled([b.euler_ratio for b in beams], PER_CENT, 3), [take(b.euler_ratio) for b in beams]),
            ("end displacement", shift, [values[:, -1] for values in shifts]),
            ("largest displacement", shift, [values.max(axis=1) for values in shifts]),
        ]
        return [[CardRow(words, scale, values[k]) for words, scale, values in columns] for k in range(len(beams))]

    def _beam(self, beam: BeamResult, rows: list[CardRow], first: int) -> Card:
        wrenches = self.poses.take(beam.section_wrenches)[:, :: self.poses.step]
        section, along = self.result.robot.beams[beam.name].section, wrenches.transpose(2, 1, 0)
        stress = section.stress_along(along, beam.stations[:: self.poses.step], beam.description.poisson_ratio).T
        lines = {"T": wrenches[..., 3], "M_y": wrenches[..., 4], "M_z": wrenches[..., 5], "stress": stress}
        lines |= {"V_y": wrenches[..., 1], "V_z": wrenches[..., 2]}
        lines |= {"axial": wrenches[..., 0], "euler": self.poses.take(beam.euler_ratio)[:, None]}
        actuators = [name for joint in self.joints if joint.beam == beam.name for name in joint.joints if name in self.actuators]
        rows = rows + [row for name in actuators for row in self._actuator(name)]
        member = "" if len(beam.member) == 1 else f" as one member with {' and '.join(n for n in beam.member if n != beam.name)}"
        note = f"Axial force: tension positive. N/N_Euler: 100 % buckles{member}."
        return Card("beam", rows, note, first, lines)

    def _joint(self, joint: DrawnJoint) -> Card:
        connections = self.result.robot.mechanism.connections
        rows: list[CardRow] = []
        wrenches: list[Array] = []
        for name in joint.joints:
            if name not in self.result.joint_wrenches:
                continue
            wrench = self.poses.take(self.result.joint_wrenches[name])
            if any(np.allclose(wrench, other, rtol=1e-9, atol=self.noise.moment, equal_nan=True) for other in wrenches):
                continue  # joints with one centre have equal wrenches, apart from the weights of links between them
            wrenches.append(wrench)
            of = f" of {name}" if wrenches[1:] else ""
            for kind, part in (("force", wrench[:, :3]), ("moment", wrench[:, 3:])):
                scale = self.noise.format(kind, part)
                rows += [
                    CardRow(f"{kind}{of}", scale, np.linalg.norm(part, axis=-1)),
                    CardRow(f"{kind}{of}: x, y, z", scale, part),
                ]
            if name in self.actuators:
                rows += self._actuator(name)
        kind = " + ".join(dict.fromkeys(connections[name].type.name for name in joint.joints)) + " joint"
        note = "Wrench of the base side acting on the platform side, about the joint's centre, world axes."
        return Card(f"{kind}, actuated" if joint.actuated else kind, rows, note if rows else "")

    def _actuator(self, name: str) -> list[CardRow]:
        values, units, noise = self.actuators[name]
        along, force = self.poses.of_configuration(values, 0), self.poses.take(self.result.actuator_forces[name])
        kind = FORCE_KINDS[actuator_unit(self.result.robot, name)]
        ((unit, factor),) = units
        words = "force" if kind == "force" else "torque"
        rows = [
            CardRow(f"position of {name}", NumberFormat(unit, factor, 4, noise), along),
            CardRow(f"{words} of {name}", self.noise.format(kind, force), force),
        ]
        if effort := self.result.robot.description.actuator_limits("effort").get(name):
            rows.append(
                CardRow(f"{words} of {name} over its effort", NumberFormat(*PER_CENT[0], 3, NOISE), np.abs(force) / effort)
            )
        return rows
