"""What there is to say about a robot, gathered so that one broken part does not hide the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from kinetostatics.configuration import Status
from kinetostatics.exceptions import AssemblyError, KinetostaticsError, StaticsError
from kinetostatics.limb_joints import Unit, limb_units
from kinetostatics.report_text import LENGTHS, quantity
from kinetostatics.sections import Rectangle, RectangularTube, Section, Tube

if TYPE_CHECKING:
    from kinetostatics.description import Beam
    from kinetostatics.mechanism import Connection
    from kinetostatics.robot import Robot
    from kinetostatics.topology import DeadWeight, Limb

T = TypeVar("T")

#: Closing error of the zero pose above which the file's own rounding shows.
CLOSED = 1e-12
#: Ratio of the smallest kept to the largest dropped singular value below which a count is doubtful.
SMALL_GAP = 1e4
#: Length over depth below which a beam is too stubby for beam theory.
STUBBY = 3.0

LETTERS = {
    "revolute": "R",
    "continuous": "R",
    "prismatic": "P",
    "cylindrical": "C",
    "universal": "U",
    "spherical": "S",
    "planar": "E",
    "floating": "F",
}


#: How the text of a problem of the zero pose alone begins.
AT_ZERO = "at the zero pose"


@dataclass
class JointFacts:
    """A joint of a limb; runs of revolutes that meet in a point are one universal or spherical joint."""

    name: str
    kind: str
    driven: bool
    joints: tuple[str, ...]


@dataclass
class LimbFacts:
    """A limb; ``word`` is its joints from base to platform, such as ``R P(driven) S``. Wrenches are None if not known."""

    name: str
    word: str
    links: tuple[str, ...]
    joints: list[JointFacts]
    beams: tuple[str, ...]
    branches: tuple[str, ...]
    rigid: bool
    mass: float | None
    constraint_wrenches: tuple[str, ...] | None = None
    attached_wrenches: tuple[str, ...] | None = None


@dataclass
class BeamFacts:
    """A beam; ``length`` [m] and ``mass`` [kg] are those of the zero pose, None if it is not known."""

    name: str
    link: str
    section: str
    telescopic: bool
    length: float | None
    depth: float
    mass: float | None
    youngs_modulus: float
    shear_modulus: float
    density: float | None
    area: float
    I_y: float
    I_z: float
    J: float
    shear_areas: tuple[float, float]


@dataclass
class DeadWeightFacts:
    """Links and joints of base or platform and of what hangs on it."""

    links: tuple[str, ...]
    joints: tuple[str, ...]
    mass: float | None


@dataclass
class RobotFacts:
    """All that a report says of a robot; what cannot be computed is None, and ``problems`` say why.

    Attributes:
        mobility: in words, such as ``3 (+6 local)``; then its numbers.
        closing_error: of the zero pose [m or rad].
        mass: of everything at the zero pose [kg].
        problems: what keeps the robot from being analysed at all.
        warnings: what to be careful about.
    """

    name: str
    file: str
    base: str
    platform: str
    mobility: str | None = None
    platform_freedoms: int | None = None
    local_freedoms: int | None = None
    redundant_constraints: int | None = None
    singular_value_gap: float | None = None
    drives: tuple[str, ...] = ()
    closing_error: float | None = None
    mass: float | None = None
    mass_follows_pose: bool = False
    limbs: list[LimbFacts] = field(default_factory=list)
    beams: list[BeamFacts] = field(default_factory=list)
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

    facts.closing_error = attempt(lambda: robot.closing_error)
    mobility = attempt(lambda: robot.mobility)
    if mobility is not None:
        facts.mobility = str(mobility)
        facts.platform_freedoms, facts.local_freedoms = mobility.platform, mobility.local
        facts.redundant_constraints, facts.singular_value_gap = mobility.redundant_constraints, mobility.gap
    masses = attempt(lambda: robot.weights.masses(robot.zero_frames)[:, 0])
    if masses is not None:
        facts.mass = float(masses.sum())
    facts.beams = _beams(robot, attempt)
    facts.mass_follows_pose = any(beam.telescopic and beam.density for beam in facts.beams)

    def mass_of(owner: str) -> float | None:
        return None if masses is None else float(masses[robot.weights.of(owner)].sum())

    facts.limbs = [_limb(robot, limb, mass_of(limb.name)) for limb in robot.topology.limbs]
    groups = attempt(lambda: robot.limb_groups)
    for group in groups or ():
        for position, number in enumerate(group.numbers):
            facts.limbs[number].constraint_wrenches = group.labels[position]
            facts.limbs[number].attached_wrenches = group.attached_labels[position]
    facts.on_base = _dead_weight(robot.topology.base, mass_of("base"))
    facts.on_platform = _dead_weight(robot.topology.platform, mass_of("platform"))
    _warn_of_file(facts)
    if groups is not None and mobility is not None:
        _warn_of_gaps(robot, facts)
        _warn_of_drives(robot, facts)
    return facts


def _limb(robot: Robot, limb: Limb, mass: float | None) -> LimbFacts:
    units = limb_units(robot.mechanism, limb)
    joints = [JointFacts(unit.label, unit.kind, not unit.passive, unit.joints) for unit in units]
    word = " ".join(_letter(unit) for unit in units) or "no joint"
    beams = tuple(edge.beam for edge in limb.edges if edge.beam)
    branches = tuple(edge.joint for edge in limb.branches if edge.joint)
    return LimbFacts(limb.name, word, limb.links, joints, beams, branches, not beams, mass)


def _letter(unit: Unit) -> str:
    return LETTERS.get(unit.kind, unit.kind) + ("" if unit.passive else "(driven)")


def _dead_weight(weight: DeadWeight, mass: float | None) -> DeadWeightFacts:
    return DeadWeightFacts(weight.links, tuple(edge.joint for edge in weight.edges if edge.joint), mass)


def _beams(robot: Robot, attempt: Callable[[Callable[[], Any]], Any]) -> list[BeamFacts]:
    models = attempt(lambda: robot.beams)
    frames = attempt(lambda: robot.zero_frames)
    found = []
    for name, beam in robot.description.beams.items():
        length = mass = None
        if models is not None and frames is not None:
            model = models[name]
            length = float(model.length(frames)[0])
            mass = model.mass if model.mass_per_length is None else model.mass_per_length * length
        found.append(_beam(beam, bool(robot.topology.beams[name].spanned), length, mass))
    return found


def _beam(beam: Beam, telescopic: bool, length: float | None, mass: float | None) -> BeamFacts:
    section = beam.section
    return BeamFacts(
        beam.name,
        beam.link,
        section_words(section),
        telescopic,
        length,
        2 * max(section.extent),
        mass,
        beam.youngs_modulus,
        beam.shear_modulus,
        beam.density,
        section.area,
        section.I_y,
        section.I_z,
        section.J,
        beam.shear_areas,
    )


def section_words(section: Section) -> str:
    """Say what a cross-section is, in mm."""

    def mm(value: float) -> str:
        return f"{1e3 * value:.5g}"

    if isinstance(section, Tube):
        if section.inner_diameter == 0:
            return f"circle ⌀{mm(section.outer_diameter)} mm"
        return f"tube ⌀{mm(section.outer_diameter)}/{mm(section.inner_diameter)} mm"
    if isinstance(section, RectangularTube):
        return f"box {mm(section.width)}×{mm(section.height)}×{mm(section.thickness)} mm"
    if isinstance(section, Rectangle):
        return f"rectangle {mm(section.width)}×{mm(section.height)} mm"
    return f"A {1e6 * section.area:.5g} mm², I_y {1e12 * section.I_y:.5g}, I_z {1e12 * section.I_z:.5g} mm⁴"


# ---- warnings ------------------------------------------------------------------------------------------------------


def _warn_of_file(facts: RobotFacts) -> None:
    """Warn of what can be seen without statics."""
    error = facts.closing_error
    if error is not None and error > CLOSED:
        facts.warnings.append(
            f"the loops stay open by {error:.2g} (m or rad) at the zero pose: the file's angles or lengths are probably rounded; "
            f"write them with full precision, as ${{pi/2}} in xacro, or assemble with a larger tolerance"
        )
    for beam in facts.beams:
        if beam.length is not None and beam.length < STUBBY * beam.depth:
            facts.warnings.append(
                f"beam {beam.name} is stubby: its length of {quantity(beam.length, LENGTHS, digits=4)} is only "
                f"{beam.length / beam.depth:.2g} times its depth; beam theory is rough below {STUBBY:g}"
            )
    rigid = [limb.name for limb in facts.limbs if limb.rigid]
    if rigid:
        which = f"the limbs {', '.join(rigid)} have" if len(rigid) > 1 else f"{rigid[0]} has"
        facts.warnings.append(f"{which} no beam between base and platform and count{'' if rigid[1:] else 's'} as rigid")
    if not facts.limbs:
        facts.warnings.append("no limb joins base and platform")
    if facts.mass == 0:
        facts.warnings.append("nothing in the file has a mass")


def _warn_of_gaps(robot: Robot, facts: RobotFacts) -> None:
    """Warn of counts that hang on a singular value which is neither zero nor not."""
    if robot.mobility.gap < SMALL_GAP:
        facts.warnings.append(
            f"the mobility is doubtful: the smallest singular value that counts is only {robot.mobility.gap:.2g} times the "
            "largest that counts as zero"
        )
    for group in robot.limb_groups:
        if group.basis.gap < SMALL_GAP:
            facts.warnings.append(
                f"the number of constraint wrenches of {group.limbs[0].name} is doubtful: the smallest singular value that "
                f"counts is only {group.basis.gap:.2g} times the largest that counts as zero"
            )


def _warn_of_drives(robot: Robot, facts: RobotFacts) -> None:
    """Warn of too few and too many drives, and of poses at which the locked drives do not hold the platform."""
    drives, mobility = len(facts.drives), robot.mobility.platform
    if drives > mobility:
        facts.warnings.append(
            f"{drives} drives for a mobility of {mobility}: the actuation is redundant; drives are taken as locked in "
            "position and share the load as their limbs' elasticity makes them"
        )
    for joint in _free_drives(robot):
        facts.warnings.append(f"the driven joint {joint.name} is in no limb: it only holds what hangs on {_owner(robot, joint)}")
    problem = _statics_problem(robot)
    if problem is not None:
        (facts.warnings if problem.startswith(AT_ZERO) else facts.problems).append(problem)


def _free_drives(robot: Robot) -> list[Connection]:
    in_limbs = {edge.joint for limb in robot.topology.limbs for edge in limb.edges}
    return [robot.mechanism.connections[name] for name in robot.description.driven if name not in in_limbs]


def _owner(robot: Robot, joint: Connection) -> str:
    for limb in robot.topology.limbs:
        if any(edge.joint == joint.name for edge in limb.branches):
            return limb.name
    return "the platform" if any(edge.joint == joint.name for edge in robot.topology.platform.edges) else "the base"


def _statics_problem(robot: Robot) -> str | None:
    """Say why the platform or a limb is not held: everywhere, or at the zero pose alone."""
    from kinetostatics.equilibrium import analyze

    if not robot.model.nq:  # nothing moves: there is one pose only
        return _complaint(lambda: analyze(robot.assemble()))
    generic = robot.model_q(robot.generic_poses).T
    tolerance = 1e-9 + 1e3 * robot.closing_error
    batch = robot.configuration(generic, tolerance=tolerance, on_failure="nan")
    if np.all(np.isin(analyze(batch).status, (Status.SINGULAR, Status.UNREACHABLE))):
        return _complaint(lambda: analyze(robot.configuration(generic[0], tolerance=tolerance)))
    zero = robot.model_q(robot.zero_poses)[:, 0]
    problem = _complaint(lambda: analyze(robot.configuration(zero, tolerance=tolerance)))
    return None if problem is None else f"{AT_ZERO} {problem}"


def _complaint(compute: Callable[[], object]) -> str | None:
    try:
        compute()
    except StaticsError as error:
        return str(error)
    except KinetostaticsError:  # said elsewhere
        return None
    return None
