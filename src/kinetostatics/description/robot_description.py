"""The description of a robot as a frozen dataclass, independent of poses.

Each part checks its values when it is made; :mod:`.validation` checks the whole, when a robot is created.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import ClassVar, TypeVar

from kinetostatics import hooks
from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, Inertia, JointStiffness, Link, Material, Origin, Spring
from kinetostatics.description.fields import IN_PYTHON, Name, Place, Text, Vector, check_fields
from kinetostatics.description.flexible import ElasticPart, Flexible
from kinetostatics.description.joint_types import JOINT_TYPES
from kinetostatics.description.joints import Joint, Loop
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.layout.report import Reported
from kinetostatics.unit_hints import angular_limit_hints, material_hints, rpy_hints

Named = TypeVar("Named", Link, Joint, Loop, Beam, Spring, Flexible)
Part = Link | Joint | Loop | Beam | JointStiffness | Spring | Flexible
#: Attributes of a description that contain its parts, by type.
TABLES: dict[type, str] = {
    Link: "links",
    Joint: "joints",
    Loop: "loops",
    Beam: "beams",
    JointStiffness: "joint_stiffness",
    Spring: "springs",
}
_ALL_TABLES = (*TABLES.values(), "flexible")


def by_name(kind: str, parts: Iterable[Named], *taken: Mapping[str, Link | Joint]) -> dict[str, Named]:
    """Return named parts by their names.

    Args:
        kind: their kind, for messages.
        parts: links, joints, loops, beams or springs.
        taken: other parts, whose names are in use.

    Raises:
        RobotFileError: two parts have the same name.
    """
    result: dict[str, Named] = {}
    for part in parts:
        for others in (*taken, result):
            if part.name in others:
                raise part.place.error(f"the {kind} name {part.name!r} is taken already, in {others[part.name].place}")
        result[part.name] = part
    return result


@dataclass(frozen=True, repr=False)
class RobotDescription(Reported):
    """Description of a robot: links, joints, loops, beams, springs, stiffnesses, platform and base.

    Attributes:
        name: name of the robot.
        links, joints, loops, beams: parts by name. The order of the links decides the numbers of the limbs.
        platform: name of the platform link.
        platform_origin: the frame o-xyz, relative to the platform link.
        base: name of the base link; empty for the root of the tree, until the description is validated.
        joint_stiffness: elastic joints, bearings and actuators, by name of the joint.
        actuated: names of the actuated joints and loops.
        attributes: names and values of further attributes of ``<robot>``.
        extra: XML of materials, other transmissions and further elements of ``<robot>``, which is preserved.
        path: path of the file; paths of meshes are relative to it.
        platform_place: file and line of the platform.
        file_warnings: warnings about the text of the file, in full sentences.
        inertia_warnings: warnings about missing moments of inertia, which concern modes and motions only.
        default_axes: names of joints and loops without an axis in the file; their axis is x.
        springs: springs between points of two links, by name.
        flexible: elastic links other than beams, by name.
        parameters: values of xacro arguments given when the file was read.
    """

    NOT_RECORDED: ClassVar = ("name", "links", "joints", "platform", "platform_origin", "base", "loops", "attributes", "extra")

    name: Name
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    platform: Text
    platform_origin: Origin = field(default_factory=Origin)
    base: str = ""
    loops: Mapping[str, Loop] = field(default_factory=dict)
    beams: Mapping[str, Beam] = field(default_factory=dict)
    joint_stiffness: Mapping[str, JointStiffness] = field(default_factory=dict)
    actuated: tuple[str, ...] = ()
    attributes: tuple[tuple[str, str], ...] = ()
    extra: str = ""
    path: str = field(default="<python>", compare=False)
    platform_place: Place = field(default=IN_PYTHON, compare=False, kw_only=True)
    file_warnings: tuple[str, ...] = field(default=(), compare=False)
    inertia_warnings: tuple[str, ...] = field(default=(), compare=False)
    default_axes: tuple[str, ...] = field(default=(), compare=False)
    springs: Mapping[str, Spring] = field(default_factory=dict)
    flexible: Mapping[str, ElasticPart] = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=ResultMapping, compare=False, repr=False)
    #: Whether the description was validated; changed copies are validated again.
    is_valid: bool = field(default=False, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, value in check_fields(self, Place(self.path), "robot").items():
            object.__setattr__(self, name, value)
        for table in _ALL_TABLES:
            object.__setattr__(self, table, ResultMapping(getattr(self, table)))
        object.__setattr__(self, "actuated", tuple(self.actuated))

    @classmethod
    def of(
        cls,
        name: str,
        *,
        links: Iterable[Link],
        joints: Iterable[Joint],
        platform: str,
        loops: Iterable[Loop] = (),
        beams: Iterable[Beam] = (),
        joint_stiffness: Iterable[JointStiffness] = (),
        springs: Iterable[Spring] = (),
        flexible: Iterable[Flexible] = (),
        **more: Keyword,
    ) -> RobotDescription:
        """Create a description from lists instead of dicts; ``more`` are further attributes, such as ``actuated``.

        Raises:
            RobotFileError: two links, joints, loops, beams or springs have the same name, or two stiffnesses the same joint.
        """
        joints_by_name = by_name("joint", joints)
        stiff: dict[str, JointStiffness] = {}
        for stiffness in joint_stiffness:
            if stiffness.joint in stiff:
                raise stiffness.place.error(f"the joint {stiffness.joint!r} has two stiffnesses")
            stiff[stiffness.joint] = stiffness
        return cls(
            name,
            by_name("link", links),
            joints_by_name,
            platform,
            loops=by_name("joint or loop", loops, joints_by_name),
            beams=by_name("beam", beams),
            joint_stiffness=stiff,
            springs=by_name("spring", springs),
            flexible=by_name("flexible link", flexible),
            **more,
        )

    @cached_property
    def urdf(self) -> str:
        """The robot file as text, with xacro expanded; programs that read URDF skip the additional elements."""
        return hooks.robot_text(self)

    @cached_property
    def elastic_links(self) -> Mapping[str, Beam | ElasticPart]:
        """Beams and other elastic links, by name."""
        return ResultMapping({**self.beams, **self.flexible})

    def actuator_limits(self, kind: str) -> Mapping[str, float]:
        """Return the limits "effort" [N, N·m] or "velocity" [m/s, rad/s] of the actuators for which the file states one."""
        connections = {**self.joints, **self.loops}
        limits = {name: float(getattr(connections[name], kind)) for name in self.actuated}
        return {name: limit for name, limit in limits.items() if limit > 0}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about probable input errors, as full sentences; most begin with file and line."""
        weightless = [
            f"{beam.place}: the beam {beam.name!r} has no density and its link no <inertial>, so that it weighs nothing; write "
            'density="0" if that is meant.'
            for beam in self.beams.values()
            if beam.density is None and beam.link in self.links and not self.links[beam.link].has_inertial
        ]
        materials = {name: (beam.material.youngs_modulus, beam.material.density) for name, beam in self.beams.items()}
        of_matrices = [
            words for part in self.flexible.values() if part.link in self.links for words in part.hints(self.links[part.link])
        ]
        return (*self.file_warnings, *weightless, *of_matrices, *self.angle_hints(), *material_hints(materials))

    def angle_hints(self) -> list[str]:
        """Return hints at angles and limits that are probably in degrees."""
        origins = [(joint.place, f"the joint {joint.name!r}", joint.origin.rpy) for joint in self.joints.values()]
        for loop in self.loops.values():
            frames = loop.predecessor_origin, loop.successor_origin
            origins += [(loop.place, f"the loop {loop.name!r}", frame.rpy) for frame in frames]
        followed = {joint.mimic.joint for joint in self.joints.values() if joint.mimic is not None}
        connections: list[Joint | Loop] = [*self.joints.values(), *self.loops.values()]
        hinges = [joint for joint in connections if JOINT_TYPES[joint.type].is_hinge and joint.name not in followed]
        return rpy_hints(origins) + angular_limit_hints((hinge.place, hinge.name, hinge.lower, hinge.upper) for hinge in hinges)

    # ---- changed copies ------------------------------------------------------------------------------------------------

    def with_part(self, part: Part) -> RobotDescription:
        """Return a copy with a link, joint, loop, beam, flexible link, spring or joint stiffness, or another of the same name."""
        name = part.joint if isinstance(part, JointStiffness) else part.name
        table = TABLES.get(type(part), "flexible")
        tables: dict[str, Keyword] = {table: {**getattr(self, table), name: part}}
        return replace(self, **tables)

    def without_beam(self, name: str) -> RobotDescription:
        """Return a copy in which a beam is rigid, with the mass of its link's ``<inertial>``.

        Raises:
            ArgumentError: there is no such beam.
        """
        if name not in self.beams:
            raise ArgumentError(f"no beam {name!r}: {near_names(name, self.beams)}")
        return replace(self, beams={key: beam for key, beam in self.beams.items() if key != name})

    def with_payload(
        self, name: str, link: str, mass: float, at: Vector = (0.0, 0.0, 0.0), inertia: Inertia | None = None
    ) -> RobotDescription:
        """Return a copy with a further link, a mass that the fixed joint "<name>_mount" attaches to ``link``.

        Args:
            name: name of the new link.
            link: the link that carries it; if it is elastic, ``at`` must be the end of a beam.
            mass: mass of the new link [kg].
            at: position of the centre of mass in the frame of ``link`` [m].
            inertia: inertia about the centre of mass; statics does not use it.

        Raises:
            ArgumentError: the name is in use.
        """
        mount = f"{name}_mount"
        for kind, new, taken in (("link", name, self.links), ("joint", mount, {**self.joints, **self.loops})):
            if new in taken:
                raise ArgumentError(f"the {kind} {new!r} is there already; give the payload another name")
        weight = Link(name, mass, inertia=inertia or Inertia())
        return self.with_part(weight).with_part(Joint(mount, "fixed", link, name, Origin(at)))

    def changed(self, name: str, /, **values: Keyword) -> RobotDescription:
        """Return a copy in which a link, joint, loop, beam, spring or joint stiffness has other values.

        ``description.changed("rod_1", section=Tube.of(0.08))`` gives a beam another diameter. If a link and a beam have the same
        name, the part that has all the attributes is changed. Attributes of a beam include those of its material.

        Args:
            name: name of the part.
            values: new values of its attributes, except the name.

        Raises:
            ArgumentError: no part has this name or attribute, or several parts have both.
        """
        matches = [(table, getattr(self, table)[name]) for table in _ALL_TABLES if name in getattr(self, table)]
        if not matches:
            names = {key for table in _ALL_TABLES for key in getattr(self, table)}
            raise ArgumentError(f"nothing in {self.name!r} is called {name!r}: {near_names(name, names)}")
        fitting = [(table, part) for table, part in matches if set(values) <= set(_attributes(part))]
        if len(fitting) != 1:
            kinds = " and ".join(f"a {type(part).__name__}" for _, part in fitting or matches)
            listed = ", ".join(values) or "nothing"
            if fitting:
                raise ArgumentError(
                    f"{name!r} is {kinds}, and {listed} may belong to either; use with_part and dataclasses.replace"
                )
            has = "; ".join(f"a {type(part).__name__} has {', '.join(_attributes(part))}" for _, part in matches)
            raise ArgumentError(f"{name!r} is {kinds}, which cannot be given {listed}: {has}")
        table, part = fitting[0]
        attributes = {key: value for key, value in values.items() if key not in _MATERIAL}
        if len(attributes) < len(values):
            material = {key: value for key, value in values.items() if key in _MATERIAL}
            attributes["material"] = replace(attributes.get("material", part.material), **material)
        tables: dict[str, Keyword] = {table: {**getattr(self, table), name: replace(part, **attributes)}}
        return replace(self, **tables)


_MATERIAL = tuple(field.name for field in fields(Material))


def _attributes(part: Part) -> Iterator[str]:
    for attribute in fields(part):
        if attribute.name not in ("name", "place") and not (isinstance(part, JointStiffness) and attribute.name == "joint"):
            yield attribute.name
    if isinstance(part, Beam):
        yield from _MATERIAL


def known_valid(description: RobotDescription) -> RobotDescription:
    """Mark a description as valid, after changes that preserve validity."""
    object.__setattr__(description, "is_valid", True)
    return description
