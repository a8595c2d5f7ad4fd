"""Properties of a robot without loads, as data for ``kinetostatics check`` and its ``--json``."""

from __future__ import annotations

from dataclasses import dataclass, field

from kinetostatics.checks.chains import Graph, JointStep
from kinetostatics.checks.local_freedoms import LocalFreedom
from kinetostatics.checks.redundancy import Redundancy
from kinetostatics.description.elements import Spring


@dataclass
class LimbFacts:
    """A limb.

    Attributes:
        name: ``limb_1``, …
        word: symbols of its joints from base to platform, such as ``R P(driven) S`` or ``R(driven) (S S | S S)``.
        like: name of the first equal limb, or None.
        graph: chain of bodies and joints.
        links, beams: names.
        joints: joints in the order of the graph.
        parts: first and last link of each part of a limb divided by pieces in series.
        rigid: whether no part of it is elastic.
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
    parts: tuple[tuple[str, str], ...]
    rigid: bool
    mass: float | None
    constraint_wrenches: tuple[str, ...] | None = None
    attached_wrenches: tuple[str, ...] | None = None


@dataclass
class BeamFacts:
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
class ElasticJointFacts:
    """An elastic joint: stiffnesses along [N/m] and about [N·m/rad] the axes of its frame; infinite ones are rigid."""

    joint: str
    kind: str
    linear: tuple[float, float, float]
    angular: tuple[float, float, float]
    drive: float | None


@dataclass
class FollowerFacts:
    """A joint that mimics another: ``multiplier`` times its coordinate plus ``offset`` [m, rad]."""

    joint: str
    kind: str
    leader: str
    multiplier: float
    offset: float


@dataclass
class MobilityFacts:
    """Mobility, local freedoms and redundant constraints.

    Attributes:
        platform: freedoms of the platform.
        local: number of freedoms that do not move it, listed in ``local_freedoms``.
        redundant_constraints: number of dependent constraints, located in ``redundancies``.
        gap: ratio of the smallest singular value taken as nonzero to the largest taken as zero; if small, the numbers are
            doubtful.
        coordinates: platform coordinates that determine its pose, as many as its freedoms.
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
class ZeroFacts:
    """The zero pose.

    Attributes:
        loop_gaps: gap of each loop with all joints at zero, ``{name: {"m": …, "rad": …}}``.
        drives: actuator coordinates at the closed zero pose [m, rad]; None if the loops do not close.
        closing_error: residual of the closed loops [scaled m or rad]; None if they do not close.
        warnings: warnings that concern this pose only.
    """

    loop_gaps: dict[str, dict[str, float]]
    drives: dict[str, float] | None = None
    closing_error: float | None = None
    warnings: list[str] = field(default_factory=list)

    def widest(self, unit: str) -> tuple[float, str]:
        """Return the largest gap in ``m`` or ``rad``, and the name of its loop."""
        return max(((item[unit], name) for name, item in self.loop_gaps.items()), default=(0.0, ""))


@dataclass
class AttachedBodiesFacts:
    """Links and joints of base or platform and of the bodies attached to it, and its ``graph``."""

    links: tuple[str, ...]
    joints: tuple[str, ...]
    mass: float | None
    graph: Graph


@dataclass
class RobotFacts:
    """Properties of a robot; None if they cannot be computed, with the reason in ``problems``.

    Attributes:
        mobility: mobility, local freedoms and redundant constraints.
        zero: the zero pose.
        mass: total mass at the zero pose [kg].
        massless: rigid links between joints without mass.
        problems: errors that prevent any analysis.
        warnings: warnings of the robot and of its zero pose.
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
    springs: list[Spring] = field(default_factory=list)
    followers: list[FollowerFacts] = field(default_factory=list)
    on_base: AttachedBodiesFacts | None = None
    on_platform: AttachedBodiesFacts | None = None
    problems: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
