"""Reading of loops, springs, counterweights, beams, driven joints and joint stiffnesses, with checks of their references."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from operator import mul

from kinetostatics.arguments import Keyword
from kinetostatics.description.elements import Beam, BeamEnd, Joint, JointStiffness, Link, Loop, Mimic, Origin, Spring, Vector
from kinetostatics.description.joint_types import JOINT_TYPES, Axes, names_of
from kinetostatics.description.robot_description import by_name
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.attributes import reference, text
from kinetostatics.files.element_tables import BEAM, COUNTERWEIGHT, JOINT_STIFFNESS, LOOP, SPRING, limits, read_section
from kinetostatics.files.xml import XmlElement

_ALIGNED = 1e-9  # sine of the largest angle between a joint's axis and an axis of its frame that counts as zero
_PARALLEL = 1e-9  # 1 − cos of the smallest angle between the two axes of a universal joint
#: Names of the joint types with one freedom.
SINGLE = ", ".join(names_of("is_single"))


# ---- axes ----------------------------------------------------------------------------------------------------------------


def lacks_axis(element: XmlElement) -> bool:
    """Whether the ``<axis>`` of a joint or loop is missing; a universal joint needs none, because its default axes are usual."""
    kind = JOINT_TYPES.get(element.attributes.get("type", ""))
    return kind is not None and kind.has_axis and kind.turns is not Axes.BOTH and element.child("axis") is None


def axis_warning(element: XmlElement) -> str:
    kind = JOINT_TYPES[text(element, "type")]
    slides = {Axes.AXIS: "slides along ", Axes.ACROSS: "slides across "}.get(kind.slides, "")
    moves = f"{slides}{'and ' * bool(slides)}turns about" if kind.turns is Axes.AXIS else slides.rstrip()
    frame = "its predecessor's <origin>" if element.tag == "loop" else "its frame"
    return f"{element.place}: {element.label} has no <axis>: by URDF's default it {moves} x of {frame}; write the axis."


# ---- <loop>, <spring>, <counterweight> -----------------------------------------------------------------------------------


def read_loops(root: XmlElement, links: Mapping[str, Link], joints: Mapping[str, Joint], warnings: list[str]) -> dict[str, Loop]:
    return by_name("joint or loop", [_loop(element, links, warnings) for element in root.named("loop")], joints)


def _loop(element: XmlElement, links: Mapping[str, Link], warnings: list[str]) -> Loop:
    found = LOOP.read(element)
    name = found["type"]
    if name not in (known := names_of("in_loop")):
        raise element.error(f"{element.label} has the type {name!r}; {near_names(name, known)}")
    kind = JOINT_TYPES[name]
    _check_sides(element, links)
    wrong = {
        "axis": (kind.has_axis, f"{name} and has no <axis>; turn its frames with <origin rpy>"),
        "axis2": (kind.turns is Axes.BOTH, f"{name} and has no <axis2>; only universal has"),
        "limit": (
            kind.is_single,
            f"{name}, and <limit> is for {SINGLE}{'; a <cone> limits it' if kind.has_cone else ''}",
        ),
        "cone": (kind.has_cone, f"{name}, and <cone> is for {' and '.join(names_of('has_cone'))}"),
    }
    for tag, (allowed, reason) in wrong.items():
        child = element.child(tag)
        if child is not None and not allowed:
            raise child.error(f"{element.label} is {reason}")
    if lacks_axis(element):
        warnings.append(axis_warning(element))
    if kind.turns is Axes.BOTH and 1 - abs(sum(map(mul, found["axis"], found["axis2"]))) < _PARALLEL:
        raise (element.child("axis2") or element.child("axis") or element).error(
            f"the two axes of {element.label} are parallel where its frames coincide; left out, <axis> is x and <axis2> is y"
        )
    limits(found, element)
    if kind.endless and math.isfinite(found["lower"]):
        reason = f"{element.label} is {name}, which means unlimited; make it revolute if it is limited"
        raise element.required_child("limit").error(reason)
    cone = found["cone"]
    if cone is not None and cone.angle > math.pi:
        if cone.angle > math.pi + 1e-9:  # a rounded π may be slightly larger
            reason = f"angle={cone.angle:g} of <cone> is above π; it is an angle between two axes, in radians"
            raise element.required_child("cone").error(reason)
        found["cone"] = replace(cone, angle=math.pi)
    return Loop(**found, place=element.place)


def _check_sides(element: XmlElement, links: Mapping[str, Link]) -> None:
    first, second = (reference(element.required_child(tag), "link", links, "link") for tag in ("predecessor", "successor"))
    if first == second:
        raise element.error(f"{element.label} joins the link {first!r} to itself")


def read_springs(root: XmlElement, links: Mapping[str, Link]) -> dict[str, Spring]:
    springs: list[Spring] = []
    for element in root.named("spring"):
        springs.append(Spring(**SPRING.read(element), place=element.place))
        _check_sides(element, links)
    return by_name("spring", springs)


def with_counterweights(
    root: XmlElement, links: Mapping[str, Link], joints: Mapping[str, Joint]
) -> tuple[dict[str, Link], dict[str, Joint]]:
    """Return links and joints, including a link with mass and its fixed joint for every ``<counterweight>``."""
    masses: list[Link] = []
    mounts: list[Joint] = []
    for element in root.named("counterweight"):
        found, place = COUNTERWEIGHT.read(element), element.place
        name, link = found["name"], reference(element, "link", links, "link")
        masses.append(Link(name, found["mass"], place=place))
        mounts.append(Joint(f"{name}_mount", "fixed", link, name, Origin(found["point"]), place=place))
    return {**links, **by_name("link", masses, links)}, {**joints, **by_name("joint", mounts, joints)}


# ---- <beam> --------------------------------------------------------------------------------------------------------------


def read_beams(
    root: XmlElement, links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]
) -> dict[str, Beam]:
    """Read all ``<beam>``; ``rigid``: the role, "base" or "platform", of each link that must not have beams."""
    beams: dict[str, Beam] = {}
    for element in root.named("beam"):
        beam = _beam(element, links, connections, rigid)
        _check_against(beam, beams, element)
        beams[beam.name] = beam
    return beams


def _beam(element: XmlElement, links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]) -> Beam:
    given = [name for name in ("poisson_ratio", "shear_modulus") if name in element.attributes]
    found = BEAM.read(element)
    link = reference(element, "link", links, "link")
    if link in rigid:
        raise element.error(
            f"the link {link!r} is the {rigid[link]}, which is rigid; give the beam a link of its own, joined to "
            f"{link!r} by a fixed joint"
        )
    start, end = (_end(element, name, connections) for name in ("from", "to"))
    if start is not None and start == end:
        raise element.error(f"{element.label} has zero length: it goes from {start.joint!r} to {start.joint!r}")
    section = read_section(element)
    if len(given) != 1:
        state = "both poisson_ratio and shear_modulus" if given else "neither poisson_ratio nor shear_modulus"
        raise element.error(f"{element.label} has {state}; give one of them")
    ratio = found["material"].poisson_ratio
    if ratio is not None and not -1 < ratio <= 0.5:
        raise element.error(f"poisson_ratio={ratio:g} of {element.label} must be above -1 and at most 0.5")
    if found["shear_coefficient"] is not None and section.shear_area_y is not None:
        raise element.error(f"{element.label} has a shear_coefficient and shear areas; leave one of them")
    values: dict[str, Keyword] = {**found, "name": found["name"] or link, "start": start, "end": end}
    beam = Beam(**values, section=section, place=element.place)
    try:
        shear_areas = beam.shear_areas
    except ArgumentError as error:
        raise element.error(f"{element.label}: {error}") from None
    if beam.y_axis is None and not (section.is_isotropic and math.isclose(*shear_areas, rel_tol=1e-12)):
        raise element.error(
            f'{element.label} has a section that bends differently about y and z: write y_axis="x y z", the '
            "direction of the section's y (a rectangle's width) in the link's frame"
        )
    return beam


def _check_against(beam: Beam, beams: Mapping[str, Beam], element: XmlElement) -> None:
    """Check a beam against the beams before it in the file."""
    for other in beams.values():
        if other.link != beam.link:
            continue
        if (other.start, other.end) == (beam.start, beam.end):
            raise element.error(
                f"two beams on the same span: {element.label} and the beam {other.name!r} (see {other.place}); give them "
                "different from and to"
            )
        if (other.density is None) != (beam.density is None):
            raise element.error(
                f"the beams of link {beam.link!r} must all give a density or none of them (see {other.place}), because a "
                "density replaces the link's <inertial>"
            )
    if beam.name in beams:
        raise element.error(f"the beam name {beam.name!r} is taken already, in {beams[beam.name].place}; rename one of them")


def _end(element: XmlElement, name: str, connections: Collection[str]) -> BeamEnd | None:
    """Read ``from`` or ``to``: the name of a joint or loop, optionally followed by a side, ``:parent`` or ``:child``."""
    if name not in element.attributes:
        return None
    value = text(element, name)
    if value in connections:  # names may contain a colon themselves
        return BeamEnd(value)
    joint, colon, side = value.rpartition(":")
    if not colon:
        joint = value
    elif side not in ("parent", "child") and joint in connections:
        raise element.error(f"{name}={value!r} of {element.label} must end in ':parent' or ':child', not {side!r}")
    if joint not in connections:
        raise element.error(
            f"{element.label} goes {name} the joint {joint!r}, which does not exist; {near_names(joint, connections)} "
            "(or is its <joint> or <loop> missing?)"
        )
    return BeamEnd(joint, side)


# ---- <transmission>, <mimic> ---------------------------------------------------------------------------------------------


def read_driven(root: XmlElement, joints: Mapping[str, Joint], loops: Mapping[str, Loop], warnings: list[str]) -> tuple[str, ...]:
    """Return the names of the joints and loops with a ``<transmission>``.

    An invalid transmission is an error if the robot has loops, because the statics depends on the driven joints; without loops it
    is a warning.
    """
    connections: list[Joint | Loop] = [*joints.values(), *loops.values()]
    types = {item.name: item.type for item in connections}
    driven: list[str] = []
    for transmission in root.named("transmission"):
        entries = transmission.named("joint")
        try:
            if not entries:
                raise transmission.error(f"{transmission.label} names no joint: write <joint name=…/> inside it")
            for entry in entries:
                name = reference(entry, "name", types, "joint")
                if name in joints and JOINT_TYPES[types[name]].is_fixed:
                    warnings.append(f"{entry.place}: the <transmission> of {name!r} is ignored, because this joint is fixed.")
                    continue
                mimic = joints[name].mimic if name in joints else None
                if not JOINT_TYPES[types[name]].is_single:
                    reason = f"is {types[name]} and cannot be driven; only joints with one freedom can: {SINGLE}"
                elif name in driven:
                    reason = "is driven by two <transmission>; name it once"
                elif mimic is not None:
                    reason = f"mimics {mimic.joint!r} and cannot be driven as well; drop one of the two"
                else:
                    driven.append(name)
                    continue
                raise entry.error(f"{name!r} {reason}")
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <transmission> is ignored.")
    return tuple(driven)


_LEADERS = "a joint can mimic a driven revolute, continuous or prismatic <joint>"


def with_valid_mimics(
    root: XmlElement, joints: Mapping[str, Joint], loops: Collection[str], warnings: list[str]
) -> dict[str, Joint]:
    """Return the joints; an invalid ``<mimic>`` is an error if there are loops, and else dropped with a warning."""
    result = dict(joints)
    for element in root.named("joint"):
        joint = joints[element.attributes["name"]]
        try:
            if joint.mimic is not None:
                _check_mimic(element, joint.mimic, joints, loops)
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <mimic> is ignored.")
            result[joint.name] = replace(joint, mimic=None)
    return result


def _check_mimic(element: XmlElement, mimic: Mimic, joints: Mapping[str, Joint], loops: Collection[str]) -> None:
    found = element.required_child("mimic")
    if mimic.joint in loops:
        raise found.error(
            f"{element.label} mimics the loop {mimic.joint!r}; {_LEADERS} of the tree: cut the loop at another joint"
        )
    leader = joints[reference(found, "joint", joints, "joint")]
    if leader.name == element.attributes["name"]:
        raise found.error(f"{element.label} mimics itself; {_LEADERS}")
    if leader.mimic is not None:
        raise found.error(f"{element.label} mimics {leader.name!r}, which mimics {leader.mimic.joint!r}; name the latter")
    if not JOINT_TYPES[leader.type].is_single:
        raise found.error(f"{element.label} mimics {leader.name!r}, which is {leader.type}; {_LEADERS}")


def check_leaders(root: XmlElement, joints: Mapping[str, Joint], driven: Collection[str]) -> None:
    for element in root.named("joint"):
        mimic = joints[element.attributes["name"]].mimic
        if mimic is not None and mimic.joint not in driven:
            raise element.required_child("mimic").error(
                f"{element.label} mimics {mimic.joint!r}, which is not driven by a <transmission>; {_LEADERS}"
            )


# ---- <joint_stiffness> ---------------------------------------------------------------------------------------------------


def read_joint_stiffness(
    root: XmlElement, joints: Mapping[str, Joint], loops: Mapping[str, Loop], driven: Collection[str]
) -> dict[str, JointStiffness]:
    """Read all ``<joint_stiffness>`` by joint; three infinite values count as missing."""
    result: dict[str, JointStiffness] = {}
    for element in root.named("joint_stiffness"):
        found = JOINT_STIFFNESS.read(element)
        name = reference(element, "joint", {**joints, **loops}, "joint")
        if name in result:
            raise element.error(f"the joint {name!r} has a <joint_stiffness> already, in {result[name].place}")
        if found["linear"] is None and found["angular"] is None and found["drive"] is None:
            raise element.error(f"{element.label} has no stiffness: give linear, angular or drive")
        joint = joints.get(name) or loops[name]
        locked = name in driven or (isinstance(joint, Joint) and joint.mimic is not None)
        for group in ("linear", "angular"):
            values = found[group]
            if values is not None and all(map(math.isinf, values)):
                found[group] = None
            elif values is not None:
                _check_group(element, group, values, joint, locked)
        if found["drive"] is not None and name not in driven:
            raise element.error(
                f"{element.label} has the attribute drive, but {name!r} is not driven; name it in a <transmission>, or drop drive"
            )
        result[name] = JointStiffness(**found, place=element.place)
    return result


def _check_group(element: XmlElement, group: str, values: Vector, joint: Joint | Loop, locked: bool) -> None:
    """Check the three linear or angular stiffnesses of a joint, which may be zero along the joint's freedoms only.

    If a direction of motion is not an axis of the joint's frame, all three values must be finite and positive.
    """
    kind = JOINT_TYPES[joint.type]
    axes = kind.slides if group == "linear" else kind.turns
    free = 0 if locked else axes.count
    if free == 3 or (free and all(0 < value < math.inf for value in values)):
        return
    if free and axes is Axes.BOTH:
        raise element.error(
            f"angular of {element.label} must be three finite numbers greater than zero, or be left out, because a {joint.type} "
            "joint's axes are not those of one frame"
        )
    constrained, where = {0, 1, 2}, {"linear": "along", "angular": "about"}
    if free:
        beside = [math.hypot(*(value for k, value in enumerate(joint.axis) if k != index)) for index in range(3)]
        along = next((index for index in range(3) if beside[index] <= _ALIGNED), None)
        if along is None:
            motion = "slides along" if group == "linear" else "turns about"
            raise element.error(
                f"{joint.name!r} {motion} an axis that is none of its frame's axes, so that {group} of {element.label} mixes "
                "free and constrained directions: turn the joint's frame (<origin rpy>) so that its axis is one of the frame's "
                "axes, or give three finite numbers greater than zero"
            )
        constrained = {along} if free == 2 else constrained - {along}  # a planar joint constrains its normal direction
    for index in sorted(constrained):
        if values[index] == 0:
            raise element.error(
                f"{group} of {element.label} is 0 {where[group]} {'xyz'[index]}, which {joint.name!r} constrains; give a number "
                "greater than zero, or inf for rigid"
            )
