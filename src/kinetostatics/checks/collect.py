"""What there is to say about a robot, gathered so that one broken part does not hide the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from kinetostatics.checks.chains import Graph
from kinetostatics.checks.limb_graph import GraphReader
from kinetostatics.checks.mobility import LocalFreedom, Motions, coordinates_of, drives_of, local_freedoms
from kinetostatics.checks.parts import (
    BeamFacts,
    ElasticJointFacts,
    FollowerFacts,
    LimbFacts,
    beam_facts,
    elastic_joints,
    first_like,
    followers,
    limb_facts,
    massless_links,
)
from kinetostatics.checks.redundancy import Redundancy, redundancies
from kinetostatics.checks.warnings import warnings_of_file, warnings_of_statics
from kinetostatics.exceptions import AssemblyError, KinetostaticsError

if TYPE_CHECKING:
    from kinetostatics.mechanism.limbs import DeadWeight
    from kinetostatics.robot import Robot

T = TypeVar("T")


@dataclass
class MobilityFacts:
    """What can move and what is held more than once.

    Attributes:
        platform: freedoms of the platform.
        local: freedoms that do not move it; ``local_freedoms`` says which.
        redundant_constraints: constraints that say nothing new; ``redundancies`` says where.
        gap: ratio of the smallest kept to the largest dropped singular value; small means that the counts are doubtful.
        coordinates: platform coordinates that place the platform, as many as its freedoms.
        redundant_drives: how many more drives there are than freedoms that they move.
        unheld: freedoms of the platform that are left with the drives locked.
    """

    platform: int
    local: int
    redundant_constraints: int
    gap: float
    coordinates: tuple[str, ...]
    redundant_drives: int
    unheld: int
    local_freedoms: list[LocalFreedom]
    redundancies: list[Redundancy]


@dataclass
class ZeroFacts:
    """The zero pose.

    Attributes:
        openings: how far each loop is open where all joints are at zero, ``{name: {"m": …, "rad": …}}``.
        drives: where the drives stand at the closed zero pose [m, rad]; None if the loops do not close.
        closing_error: how far the closed loops stay open [scaled m or rad]; None if they do not close.
    """

    openings: dict[str, dict[str, float]]
    drives: dict[str, float] | None = None
    closing_error: float | None = None

    def widest(self, unit: str) -> tuple[float, str]:
        """Return the largest opening in ``m`` or ``rad``, and the loop's name."""
        return max(((item[unit], name) for name, item in self.openings.items()), default=(0.0, ""))


@dataclass
class DeadWeightFacts:
    """Links and joints of base or platform and of what hangs on it, and its ``graph``."""

    links: tuple[str, ...]
    joints: tuple[str, ...]
    mass: float | None
    graph: Graph


@dataclass
class RobotFacts:
    """All that a report says of a robot; what cannot be computed is None, and ``problems`` say why.

    Attributes:
        mobility: numbers and what they mean.
        zero: the zero pose.
        mass: of everything at the zero pose [kg].
        massless: rigid links between joints that weigh nothing.
        problems: what keeps the robot from being analysed at all.
        warnings: what to be careful about.
    """

    name: str
    file: str
    base: str
    platform: str
    mobility: MobilityFacts | None = None
    drives: tuple[str, ...] = ()
    zero: ZeroFacts = field(default_factory=lambda: ZeroFacts({}))
    mass: float | None = None
    mass_follows_pose: bool = False
    massless: tuple[str, ...] = ()
    limbs: list[LimbFacts] = field(default_factory=list)
    beams: list[BeamFacts] = field(default_factory=list)
    elastic_joints: list[ElasticJointFacts] = field(default_factory=list)
    followers: list[FollowerFacts] = field(default_factory=list)
    on_base: DeadWeightFacts | None = None
    on_platform: DeadWeightFacts | None = None
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def robot_facts(robot: Robot) -> RobotFacts:
    """Gather what there is to say about a robot; errors become problems."""
    description = robot.description
    facts = RobotFacts(robot.name, description.path, description.base, description.platform, drives=description.driven)
    facts.warnings += [*description.warnings, *robot.topology.warnings]

    open_loops = False

    def attempt(compute: Callable[[], T]) -> T | None:
        nonlocal open_loops
        if open_loops:  # all else needs a closed pose, and looking for it again takes a second each time
            return None
        try:
            return compute()
        except KinetostaticsError as error:
            open_loops = isinstance(error, AssemblyError)
            if str(error) not in facts.problems:
                facts.problems.append(str(error))
            return None

    facts.zero = ZeroFacts({name: {"m": metres, "rad": radians} for name, (metres, radians) in robot.zero_gaps.items()})
    if robot.wrong_zero is not None:
        facts.problems.append(str(robot.wrong_zero))
        open_loops = True
    facts.zero.closing_error = attempt(lambda: robot.closing_error)
    groups = attempt(lambda: robot.statics.groups)
    if groups is not None:
        facts.mobility = attempt(lambda: _mobility(robot, facts.zero))
    masses = attempt(lambda: robot.weights.masses(robot.zero_frames)[:, 0])
    if masses is not None:
        facts.mass = float(masses.sum())

    def mass_of(owner: str) -> float | None:
        return None if masses is None else float(masses[robot.weights.of(owner)].sum())

    reader = GraphReader(robot.mechanism)
    facts.limbs = [limb_facts(robot, reader, limb, mass_of(limb.name)) for limb in robot.topology.limbs]
    labels = {joint: step.name for limb in facts.limbs for step in limb.joints for joint in step.joints}
    facts.beams = beam_facts(robot, labels, attempt)
    facts.mass_follows_pose = any(beam.telescopic and beam.density for beam in facts.beams)
    alike: dict[tuple[object, ...], str] = {}
    for group in groups or ():
        for position, which in enumerate(group.numbers):
            if which < len(facts.limbs):
                facts.limbs[which].constraint_wrenches = group.labels[position]
                facts.limbs[which].attached_wrenches = group.attached_labels[position]
    for limb in facts.limbs if groups is not None else ():
        limb.like = first_like(limb, facts.beams, alike)
    facts.massless = massless_links(robot, facts.limbs)
    facts.elastic_joints = elastic_joints(robot)
    facts.followers = followers(robot)
    facts.on_base = _dead_weight(robot.topology.base, mass_of("base"), reader.dead_weight(robot.topology, "base"))
    facts.on_platform = _dead_weight(robot.topology.platform, mass_of("platform"), reader.dead_weight(robot.topology, "platform"))
    facts.warnings += warnings_of_file(robot, facts)
    if groups is not None and facts.mobility is not None:
        warnings, problems = warnings_of_statics(robot, facts)
        facts.warnings += warnings
        facts.problems += problems
    return facts


# ---- parts -----------------------------------------------------------------------------------------------------------


def _mobility(robot: Robot, zero: ZeroFacts) -> MobilityFacts:
    found, motions = robot.mobility, Motions(robot)
    drives = drives_of(motions)
    values = robot.solver.values(robot.actuator_request, robot.zero_poses)[:, 0]
    zero.drives = {name: float(value) for name, value in zip(motions.drive_names, values, strict=True)}
    return MobilityFacts(
        found.platform,
        found.local,
        found.redundant_constraints,
        found.gap,
        coordinates_of(motions),
        drives.redundant,
        drives.unheld,
        local_freedoms(motions),
        redundancies(motions),
    )


def _dead_weight(weight: DeadWeight, mass: float | None, graph: Graph) -> DeadWeightFacts:
    return DeadWeightFacts(weight.links, tuple(edge.joint for edge in weight.edges if edge.joint), mass, graph)
