"""Properties of a robot without loads (*facts*), as data for ``kinetostatics check`` and its ``--json``."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from kinetostatics.checks.chains import Branches, Chain, Graph, GraphReader, JointStep, bodies_of, joints_of
from kinetostatics.checks.local_freedoms import LocalFreedom
from kinetostatics.checks.redundancy import Redundancy
from kinetostatics.description.elements import Spring
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.stiffness_matrix import is_coupled
from kinetostatics.elements.beam import BeamModel
from kinetostatics.elements.link import ElasticLink
from kinetostatics.limbs.geometry import Basis
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import EQUAL
from kinetostatics.mechanism.joints import elastic_actuators, springs_of
from kinetostatics.mechanism.limbs import Limb
from kinetostatics.mechanism.tree import Frames
from kinetostatics.robot import Robot
from kinetostatics.sections.kinds import Rectangle, RectangularTube, Section, Tube
from kinetostatics.sections.tapered import Tapered


@dataclass
class LimbDiagnosis:
    """A limb.

    Attributes:
        name: ``limb_1``, …
        word: symbols of its joints from base to platform, such as ``R P(actuated) S`` or ``R(actuated) (S S | S S)``.
        like: name of the first equal limb, or None.
        graph: chain of bodies and joints.
        joints: joints in the order of the graph.
        parts: (inner link, outer link) at the ends of each part, if the limb consists of several parts in series.
        rigid: whether no part of the limb is elastic.
        mass: mass at the zero pose [kg], None if unknown.
        constraint_wrenches, attached_wrenches: descriptions, None if unknown.
    """

    name: str
    word: str
    like: str | None
    graph: Graph
    links: tuple[str, ...]
    joints: list[JointStep]
    beams: tuple[str, ...]
    flexible: tuple[str, ...]
    parts: tuple[tuple[str, str], ...]
    rigid: bool
    mass: float | None
    constraint_wrenches: tuple[str, ...] | None = None
    attached_wrenches: tuple[str, ...] | None = None


@dataclass
class BeamDiagnosis:
    """A beam; ``length`` [m] and ``mass`` [kg] at the zero pose, None if unknown.

    ``start`` and ``end`` name the joints at its ends, base to platform; ``depth`` [m] is the section's larger side or diameter.
    """

    name: str
    link: str
    start: str
    end: str
    section: str
    telescopic: bool
    length: float | None
    depth: float
    mass: float | None
    youngs_modulus: float
    shear_modulus: float
    density: float | None
    thermal_expansion: float
    area: float
    I_y: float
    I_z: float
    J: float
    shear_areas: tuple[float, float]


@dataclass
class FlexibleDiagnosis:
    """An elastic link that is no beam, with its interfaces, its mass [kg], None if unknown, and its numbers that may vary."""

    name: str
    link: str
    interfaces: tuple[str, ...]
    mass: float | None
    numbers: dict[str, float]


@dataclass
class ElasticJointDiagnosis:
    """An elastic joint: stiffnesses along [N/m] and about [N·m/rad] the axes of its frame; inverse compliances if ``coupled``."""

    joint: str
    kind: str
    linear: tuple[float, ...]
    angular: tuple[float, ...]
    drive: float | None
    coupled: bool = False


@dataclass
class FollowerDiagnosis:
    """A joint whose coordinate is ``multiplier`` times the coordinate of ``leader``, plus ``offset`` [m, rad]."""

    joint: str
    kind: str
    leader: str
    multiplier: float
    offset: float


@dataclass
class MobilityDiagnosis:
    """Mobility, local freedoms and redundant constraints.

    Attributes:
        platform: freedoms of the platform.
        local: number of freedoms that do not move the platform, listed in ``local_freedoms``.
        redundant_constraints: number of dependent constraints, located in ``redundancies``.
        gap: ratio of the smallest singular value taken as nonzero to the largest taken as zero; if it is small, the numbers of
            freedoms are doubtful.
        coordinates: coordinates that determine the platform's pose, as many as its freedoms.
        redundant_actuators: number of actuators minus number of freedoms that they move.
        uncontrolled_freedoms: number of freedoms of the platform with locked actuators.
    """

    platform: int
    local: int
    redundant_constraints: int
    gap: float
    coordinates: tuple[str, ...]
    redundant_actuators: int
    uncontrolled_freedoms: int
    local_freedoms: list[LocalFreedom]
    redundancies: list[Redundancy]


@dataclass
class ZeroDiagnosis:
    """The zero pose.

    Attributes:
        loop_gaps: gap of each loop with all joints at zero, ``{name: {"m": …, "rad": …}}``.
        actuators: actuator coordinates at the closed zero pose [m, rad]; None if the loops do not close.
        closing_error: residual of the closed loops [scaled m or rad]; None if they do not close.
        warnings: warnings that concern this pose only.
    """

    loop_gaps: dict[str, dict[str, float]]
    actuators: dict[str, float] | None = None
    closing_error: float | None = None
    warnings: list[str] = field(default_factory=list)

    def widest(self, unit: str) -> tuple[float, str]:
        """Return the largest gap in the ``unit`` m or rad, and the name of its loop."""
        return max(((gap[unit], name) for name, gap in self.loop_gaps.items()), default=(0.0, ""))


@dataclass
class AttachedBodiesDiagnosis:
    """Links and joints of the base, or of the platform, and of the bodies attached to it; ``mass`` of all of them [kg]."""

    links: tuple[str, ...]
    joints: tuple[str, ...]
    mass: float | None
    graph: Graph


@dataclass
class Diagnosis:
    """Properties of a robot; a property that cannot be computed is None, and ``problems`` has the reason.

    Attributes:
        mass: total mass at the zero pose [kg].
        mass_follows_pose: whether the mass of a telescopic beam changes with its length.
        massless: massless links without beams that are between joints.
        problems: errors that prevent any analysis.
        warnings: all warnings: of the robot, of its zero pose, and of its inertias.
        inertia_warnings: warnings that concern modes and motions only.
    """

    name: str
    file: str
    base: str
    platform: str
    mobility: MobilityDiagnosis | None = None
    actuators: tuple[str, ...] = ()
    zero: ZeroDiagnosis = field(default_factory=lambda: ZeroDiagnosis({}))
    mass: float | None = None
    mass_follows_pose: bool = False
    massless: tuple[str, ...] = ()
    limbs: list[LimbDiagnosis] = field(default_factory=list)
    beams: list[BeamDiagnosis] = field(default_factory=list)
    flexible: list[FlexibleDiagnosis] = field(default_factory=list)
    elastic_joints: list[ElasticJointDiagnosis] = field(default_factory=list)
    springs: list[Spring] = field(default_factory=list)
    followers: list[FollowerDiagnosis] = field(default_factory=list)
    on_base: AttachedBodiesDiagnosis | None = None
    on_platform: AttachedBodiesDiagnosis | None = None
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    inertia_warnings: list[str] = field(default_factory=list)


def limb_diagnosis(robot: Robot, reader: GraphReader, limb: Limb, mass: float | None) -> LimbDiagnosis:
    """Return the properties of a limb that do not depend on its pose."""
    graph = reader.limb(limb)
    links = [edge.span for edge in limb.edges if edge.span]
    tables = robot.description.beams, robot.description.flexible
    beams, flexible = (tuple(dict.fromkeys(name for name in links if name in table)) for table in tables)
    moved = {joint for actuator in elastic_actuators(robot.mechanism).values() for joint, _ in actuator.moves}
    sprung = any(springs_of(robot.mechanism, edge.joint) or edge.joint in moved for edge in limb.edges if edge.joint)
    parts = tuple((part.start, part.end) for part in limb.parts) if len(limb.parts) > 1 else ()
    word = _symbols(graph.chain) or "welded"
    return LimbDiagnosis(
        limb.name, word, None, graph, limb.links, joints_of(graph.chain), beams, flexible, parts, not links and not sprung, mass
    )


def _symbols(chain: Chain) -> str:
    """Return the symbols of a chain's joints, such as ``R(actuated) (S S | S S)``; networks are in square brackets."""
    words = []
    for part in chain:
        if isinstance(part, JointStep):
            if part.elastic or not JOINT_TYPES[part.kind].is_fixed:
                words.append(JOINT_TYPES[part.kind].symbol + ("(actuated)" if part.actuated else ""))
        elif isinstance(part, Branches):
            branches = [_symbols(run.chain) for run in part.runs]
            network = f"[{' '.join(filter(None, branches)) or '–'}]"
            words.append(f"({' | '.join(symbols or '–' for symbols in branches)})" if part.parallel else network)
    return " ".join(words)


def first_like(limb: LimbDiagnosis, basis: Basis, beams: list[BeamDiagnosis], alike: dict[tuple[object, ...], str]) -> str | None:
    """Return the name of an equal limb in ``alike``; if there is none, add this limb to ``alike`` and return None."""

    def rounded(value: float | None) -> str:
        return "" if value is None else f"{value * (1 + EQUAL**2):.5g}"  # avoids ties in the rounding of short decimals

    limb_beams = [beam for beam in beams if beam.name in limb.beams]
    rows = tuple(
        (beam.section, beam.telescopic, rounded(beam.length), rounded(beam.youngs_modulus), rounded(beam.density))
        for beam in limb_beams
    )
    wrenches = tuple(
        tuple((c.direction[0] if c.direction[0] == "complement" else c.direction, c.centre) for c in part)
        for part in (basis.constraint, basis.attached)
    )
    first = alike.setdefault((limb.word, rounded(limb.mass), rows, limb.flexible, wrenches), limb.name)
    return None if first == limb.name else first


def massless_links(robot: Robot, limbs: list[LimbDiagnosis]) -> tuple[str, ...]:
    """Return the massless links without beams between joints, except the crosses of universal and spherical joints."""
    description = robot.description
    elastic = {link.link for link in description.elastic_links.values()}
    chains = [chain for limb in limbs for chain in (limb.graph.chain, *(branch.chain for branch in limb.graph.hanging))]
    shown = {name for chain in chains for name in bodies_of(chain)}
    return tuple(name for name in description.links if name in shown - elastic and description.links[name].mass == 0)


def flexible_diagnosis(robot: Robot, links: Mapping[str, ElasticLink] | None, frames: Frames | None) -> list[FlexibleDiagnosis]:
    """Return the properties of elastic links that are no beams; ``links`` and ``frames`` of the zero pose are None if unknown."""
    diagnoses = []
    for name, part in robot.description.flexible.items():
        mass = None if links is None or frames is None else float(f"{links[name].mass_at(frames)[0]:.12g}")
        numbers = {key: getattr(part, key) for key in part.numbers}
        diagnoses.append(FlexibleDiagnosis(name, part.link, part.interfaces, mass, numbers))
    return diagnoses


def elastic_joints(robot: Robot) -> list[ElasticJointDiagnosis]:
    diagnoses = []
    for name, stiffness in robot.description.joint_stiffness.items():
        drive = stiffness.drive if name in elastic_actuators(robot.mechanism) else None
        springs = springs_of(robot.mechanism, name)
        if springs or drive is not None:
            compliance = springs[0].compliance if springs else np.zeros((6, 6))
            kind = robot.mechanism.connections[name].type.name
            linear, angular = (_stiffnesses(compliance[rows, rows]) for rows in (slice(3), slice(3, 6)))
            diagnoses.append(ElasticJointDiagnosis(name, kind, linear, angular, drive, is_coupled(compliance)))
    return diagnoses


def _stiffnesses(compliances: Array) -> tuple[float, ...]:
    """Return the stiffnesses along the axes from compliances (3, 3); infinite for rigid directions."""
    return tuple(1 / float(c) if c > 0 else np.inf for c in np.diag(compliances))


def followers(robot: Robot) -> list[FollowerDiagnosis]:
    return [
        FollowerDiagnosis(joint.name, joint.type.name, joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset)
        for joint in robot.mechanism.connections.values()
        if joint.mimic is not None
    ]


def beam_diagnosis(
    robot: Robot, labels: dict[str, str], models: Mapping[str, BeamModel] | None, frames: Frames | None
) -> list[BeamDiagnosis]:
    """Return the properties of all beams.

    ``labels``: for each revolute of a universal or spherical joint, the name of that joint. ``models`` and ``frames``: beam
    models, and frames of the zero pose; None if unknown.
    """
    diagnoses = []
    for name, beam in robot.description.beams.items():
        section, span = beam.section, robot.topology.spans[name]
        length = mass = None
        if models is not None and frames is not None:  # rounded, so that equal beams have equal numbers
            length = float(f"{models[name].length(frames)[0]:.12g}")
            mass = float(f"{models[name].mass_at(frames)[0]:.12g}")
        given = {end.joint for end in (beam.start, beam.end) if end is not None}
        diagnoses.append(
            BeamDiagnosis(
                name=name,
                link=beam.link,
                start=_end_name(robot, labels, given, span.start_link, span.start),
                end=_end_name(robot, labels, given, span.end_link, span.end),
                section=section_words(section),
                telescopic=bool(span.spanned),
                length=length,
                depth=2 * max(section.extent),
                mass=mass,
                youngs_modulus=beam.youngs_modulus,
                shear_modulus=beam.shear_modulus,
                density=beam.density,
                thermal_expansion=beam.thermal_expansion,
                area=section.area,
                I_y=section.I_y,
                I_z=section.I_z,
                J=section.J,
                shear_areas=beam.shear_areas,
            )
        )
    return diagnoses


def _end_name(robot: Robot, labels: dict[str, str], given: Collection[str], link: str, point: Array) -> str:
    """Return the name of a joint at a ``point`` (3,) of a link, preferably one of ``given``; without a joint, the link's name."""
    here = [joint for joint in robot.mechanism.at_link[link] if float(np.max(np.abs(joint.centre_on(link) - point))) < 1e-6]
    if not here:
        return link
    best = min(here, key=lambda joint: (joint.name not in given, joint.type.is_fixed))
    return labels.get(best.name, best.name)


def section_words(section: Section) -> str:
    """Return a cross-section as text, in mm."""

    def mm(value: float) -> str:
        return f"{1e3 * value:.5g}"

    if isinstance(section, Tapered):
        return ", ".join(f"{section_words(station.section)} at {station.at:g}" for station in section.stations)
    if isinstance(section, Tube):
        if section.inner_diameter == 0:
            return f"circle ⌀{mm(section.outer_diameter)} mm"
        return f"tube ⌀{mm(section.outer_diameter)}/{mm(section.inner_diameter)} mm"
    if isinstance(section, RectangularTube):
        return f"box {mm(section.width)}×{mm(section.height)}×{mm(section.thickness)} mm"
    if isinstance(section, Rectangle):
        return f"rectangle {mm(section.width)}×{mm(section.height)} mm"
    return f"A {1e6 * section.area:.5g} mm², I_y {1e12 * section.I_y:.5g}, I_z {1e12 * section.I_z:.5g} mm⁴"
