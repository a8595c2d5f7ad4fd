"""Rules that concern several parts of a description: references by name, the tree, actuated and mimicking joints, beams.

Files and descriptions made in Python are checked by the same functions; errors have the line of parts that are from a file.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from kinetostatics.description.elements import Beam, BeamEnd, JointStiffness, Link, Spring, check_section
from kinetostatics.description.fields import Place
from kinetostatics.description.flexible import ElasticPart
from kinetostatics.description.joint_types import Axes
from kinetostatics.description.joints import NO_LIMITS, SINGLE, Joint, Loop
from kinetostatics.description.robot_description import TABLES, RobotDescription, by_name, known_valid
from kinetostatics.description.stiffness_matrix import full_matrix
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.sections.kinds import Section
from kinetostatics.sections.tapered import UNIFORM, Tapered

_ALIGNED = 1e-9  # sine of the largest angle between a joint's axis and an axis of its frame that counts as zero
_ATTRIBUTE = re.compile(r"[A-Za-z_][\w:.-]*")


class Where(Protocol):
    """What makes errors: a place, or an element of a file."""

    def error(self, reason: str) -> RobotFileError: ...


def validate(description: RobotDescription) -> RobotDescription:
    """Validate a description created or changed in Python by the rules of robot files.

    Args:
        description: the description; returned unchanged if valid already.

    Returns:
        The description with its base, and without what has no effect: limits of joints that turn endlessly, mimicking fixed
        joints, rigid stiffnesses.

    Raises:
        RobotFileError: the description is invalid; with file and line for parts of a file.
        ArgumentError: the argument is no description.
    """
    if not isinstance(description, RobotDescription):
        raise ArgumentError(f"{description!r} is no description of a robot; load_robot and read_robot_file read files")
    if description.is_valid:
        return description
    place, warnings = Place(description.path), list[str]()
    check_attributes(dict(description.attributes), place)
    for kind, table in TABLES.items():
        for key, part in getattr(description, table).items():
            name = getattr(part, "joint" if kind is JointStiffness else "name", None)
            if not isinstance(part, kind) or name != key:
                where = getattr(part, "place", place)
                raise where.error(f"the entry {key!r} of {table} is {part!r}; it must be a {kind.__name__} of this name")
    links, loops = description.links, description.loops
    joints = {name: usual_joint(joint, warnings) for name, joint in description.joints.items()}
    platform, platform_place = description.platform, description.platform_place
    check_reference(platform_place, "<platform>", "link", platform, links)
    tree = tree_root(links, joints)
    check_loops(loops, links, joints)
    base = description.base or tree
    check_reference(place, "<base>", "link", base, links)
    joints = with_valid_mimics(joints, loops, warnings)
    transmissions = [(place, "", [(name, place)]) for name in description.actuated]
    actuated = valid_actuated(transmissions, joints, loops, warnings)
    if base == platform:
        raise platform_place.error(f"the link {base!r} is both base and platform")
    for joint in joints.values():
        if joint.mimic is not None and joint.mimic.joint not in actuated:
            raise joint.place.of("mimic").error(
                f"{joint.label} mimics {joint.mimic.joint!r}, which is not actuated by a <transmission>; {_LEADERS}"
            )
    connections: dict[str, Joint | Loop] = {**joints, **loops}
    _check_beams(description.beams.values(), links, connections, {base: "base", platform: "platform"})
    for part in description.flexible.values():
        check_reference(part.place, f"<{part.KIND} {part.name!r}>", "link", part.link, links)
        held = [joint for joint in joints.values() if not joint.of_type.is_free or joint.name in description.joint_stiffness]
        at_link = [joint.name for joint in held if part.link in (joint.parent, joint.child)]
        at_link += [loop.name for loop in loops.values() if part.link in (loop.predecessor, loop.successor)]
        elastic: tuple[Beam | ElasticPart, ...] = (*description.beams.values(), *description.flexible.values())
        others = [other for other in elastic if other is not part and other.link == part.link]
        part.check_place(at_link, others, {base: "base", platform: "platform"}.get(part.link, ""))
        if part.name in description.beams:
            raise part.place.error(f"<{part.KIND} {part.name!r}> has the name of a beam, in {description.beams[part.name].place}")
    stiffnesses = {name: _stiffness(stiffness, connections, actuated) for name, stiffness in description.joint_stiffness.items()}
    for spring in description.springs.values():
        _check_sides(spring, links)
    file_texts = {warning.partition(": ")[2] for warning in description.file_warnings}
    new = [warning for warning in warnings if warning.partition(": ")[2] not in file_texts]
    result = replace(
        description,
        joints=joints,
        base=base,
        actuated=actuated,
        joint_stiffness=stiffnesses,
        attributes=tuple((name, text) for name, text in description.attributes if name != "name"),
        file_warnings=(*description.file_warnings, *new),
    )
    return known_valid(result)


def check_attributes(attributes: Mapping[str, str], where: Where) -> None:
    """Check further attributes of ``<robot>``."""
    for name, value in attributes.items():
        if not isinstance(name, str) or not _ATTRIBUTE.fullmatch(name) or not isinstance(value, str) or not value.isprintable():
            raise where.error(f"{name!r} = {value!r} is no attribute for <robot>")
    version = attributes.get("version", "1.0")
    if version.strip() not in ("1.0", "1"):
        raise where.error(f"version={version!r} of <robot> is unknown; URDF has version 1.0")


def check_reference(where: Where, label: str, kind: str, name: object, part_names: Collection[str]) -> None:
    """Raise an error if a name of a ``kind`` of parts is not among ``part_names``; ``label`` is what refers to it."""
    if not isinstance(name, str) or name not in part_names:
        raise where.error(f"{label} refers to the {kind} {name!r}, which does not exist; {near_names(name, part_names)}")


def _check_sides(part: Joint | Loop | Spring, links: Collection[str], tags: Sequence[str] = ("predecessor", "successor")) -> None:
    first, second = (getattr(part, tag) for tag in tags)
    for tag, link in zip(tags, (first, second), strict=True):
        check_reference(part.place.of(tag), f"<{tag}> of {part.label}", "link", link, links)
    if first == second:
        raise part.place.error(f"{part.label} joins the link {first!r} to itself")


# ---- joints, loops and the tree ------------------------------------------------------------------------------------------


def usual_joint(joint: Joint, warnings: list[str]) -> Joint:
    """Return a joint without limits and a mimicked joint that have no effect."""
    if joint.mimic is not None and joint.of_type.is_fixed:
        warnings.append(f"{joint.place.of('mimic')}: <mimic> of {joint.label} is ignored, because this joint is fixed.")
        joint = replace(joint, mimic=None)
    if joint.of_type.has_limits or (joint.lower, joint.upper) == NO_LIMITS:
        return joint
    if joint.of_type.is_single:
        warnings.append(
            f"{joint.place.of('limit')}: lower and upper of {joint.label} are ignored, because it is {joint.type}; make it "
            "revolute if it is limited."
        )
    return replace(joint, lower=-math.inf, upper=math.inf)


def tree_root(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> str:
    """Return the root link; links and joints that do not form a tree are an error."""
    to_parent: dict[str, Joint] = {}
    for joint in joints.values():
        _check_sides(joint, links, ("parent", "child"))
        other = to_parent.setdefault(joint.child, joint)
        if other is not joint:
            raise joint.place.error(
                f"link {joint.child!r} has two parents, by the joints {other.name!r} and {joint.name!r}; "
                "make one of them a <loop>",
            )
    roots = [name for name in links if name not in to_parent]
    if len(roots) > 1:
        listed = ", ".join(map(repr, roots[:6])) + (", …" if len(roots) > 6 else "")
        raise links[roots[1]].place.error(
            f"{len(roots)} links have no parent joint ({listed}); only the root may have none: make every other link the child "
            "of one <joint>, and further joints <loop>"
        )
    on_tree = set(roots)
    for start in links:
        path: dict[str, None] = {}  # used as an ordered set
        link = start
        while link not in on_tree and link not in path:
            path[link] = None
            link = to_parent[link].parent
        if link in path:
            cycle = list(path)[list(path).index(link) :]
            listed = ", ".join(map(repr, cycle))
            raise links[cycle[0]].place.error(f"the joints form a cycle through the links {listed}; make one of them a <loop>")
        on_tree.update(path)
    return roots[0]


def check_loops(loops: Mapping[str, Loop], links: Collection[str], joints: Mapping[str, Joint]) -> None:
    by_name("joint or loop", loops.values(), joints)
    for loop in loops.values():
        _check_sides(loop, links)


_LEADERS = "a joint can mimic an actuated revolute, continuous or prismatic <joint>"


def with_valid_mimics(joints: Mapping[str, Joint], loops: Collection[str], warnings: list[str]) -> dict[str, Joint]:
    """Return the joints; an invalid ``<mimic>`` is an error if there are loops, and else dropped with a warning."""
    result = dict(joints)
    for joint in joints.values():
        try:
            _check_mimic(joint, joints, loops)
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <mimic> is ignored.")
            result[joint.name] = replace(joint, mimic=None)
    return result


def _check_mimic(joint: Joint, joints: Mapping[str, Joint], loops: Collection[str]) -> None:
    if joint.mimic is None:
        return
    name, place = joint.mimic.joint, joint.place.of("mimic")
    if name in loops:
        raise place.error(f"{joint.label} mimics the loop {name!r}; {_LEADERS} of the tree: cut the loop at another joint")
    check_reference(place, f"<mimic> of {joint.label}", "joint", name, joints)
    leader = joints[name]
    if leader.name == joint.name:
        raise place.error(f"{joint.label} mimics itself; {_LEADERS}")
    if leader.mimic is not None:
        raise place.error(f"{joint.label} mimics {name!r}, which mimics {leader.mimic.joint!r}; name the latter")
    if not leader.of_type.is_single:
        raise place.error(f"{joint.label} mimics {name!r}, which is {leader.type}; {_LEADERS}")


def valid_actuated(
    transmissions: Iterable[tuple[Where, str, Iterable[tuple[str, Place]]]],
    joints: Mapping[str, Joint],
    loops: Mapping[str, Loop],
    warnings: list[str],
) -> tuple[str, ...]:
    """Return the names of the actuated joints and loops.

    An invalid transmission is an error if the robot has loops, because the statics depends on the actuated joints; without loops
    it is a warning.

    Args:
        transmissions: of each transmission what makes its errors, its label, and the names of its joints with their places.
        joints, loops: of the robot.
        warnings: list to which warnings are added.
    """
    connections: dict[str, Joint | Loop] = {**joints, **loops}
    actuated: list[str] = []
    for where, label, entries in transmissions:
        try:
            if not entries:
                raise where.error(f"{label} names no joint: write <joint name=…/> inside it")
            for name, place in entries:
                check_reference(place, "<transmission>", "joint", name, connections)
                joint = connections[name]
                mimic = joint.mimic if isinstance(joint, Joint) else None
                if isinstance(joint, Joint) and joint.of_type.is_fixed:
                    warnings.append(f"{place}: the <transmission> of {name!r} is ignored, because this joint is fixed.")
                elif not joint.of_type.is_single:
                    reason = f"is {joint.type} and cannot be actuated; only joints with one freedom can: {SINGLE}"
                    raise place.error(f"{name!r} {reason}")
                elif name in actuated:
                    raise place.error(f"{name!r} is actuated by two <transmission>; name it once")
                elif mimic is not None:
                    raise place.error(f"{name!r} mimics {mimic.joint!r} and cannot be actuated as well; drop one of the two")
                else:
                    actuated.append(name)
        except RobotFileError as error:
            if loops:
                raise
            warnings.append(f"{error}; this <transmission> is ignored.")
    return tuple(actuated)


# ---- beams ---------------------------------------------------------------------------------------------------------------


def _check_beams(beams: Collection[Beam], links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]) -> None:
    """Check all beams; ``rigid``: the role, "base" or "platform", of each link that must not have beams."""
    for beam in beams:
        _check_beam(beam, links, connections, rigid)
    check_pairs(list(beams))


def _check_beam(beam: Beam, links: Collection[str], connections: Collection[str], rigid: Mapping[str, str]) -> None:
    place, label, material = beam.place, beam.label, beam.material
    check_reference(place, label, "link", beam.link, links)
    if beam.link in rigid:
        raise place.error(
            f"the link {beam.link!r} is the {rigid[beam.link]}, which is rigid; give the beam a link of its own, joined to "
            f"{beam.link!r} by a fixed joint"
        )
    for name, end in (("from", beam.start), ("to", beam.end)):
        if end is not None:
            _check_end(beam, name, end, connections)
    if beam.start is not None and beam.start == beam.end:
        raise place.error(f"{label} has zero length: it goes from {beam.start.joint!r} to {beam.start.joint!r}")
    if type(beam.section) not in (*UNIFORM, Tapered):
        raise place.error(f"the section of {label} is {beam.section!r}; take one of kinetostatics.sections")
    try:
        check_section(beam.section)
    except ArgumentError as error:
        raise place.error(f"section of {label}: {error}") from None
    if beam.section.places and beam.density is None:
        raise place.error(f"{label} has stations, but no density; give one, so that its mass follows its sections")
    if (material.poisson_ratio is None) == (material.shear_modulus is None):
        state = "neither poisson_ratio nor" if material.poisson_ratio is None else "both poisson_ratio and"
        raise place.error(f"{label} has {state} shear_modulus; give one of them")
    if material.poisson_ratio is not None and not -1 < material.poisson_ratio <= 0.5:
        raise place.error(f"poisson_ratio={material.poisson_ratio:g} of {label} must be above -1 and at most 0.5")
    if material.yield_strength is not None and type(beam.section) is Section:
        raise place.error(f"{label} has a yield_strength, but no stress: the outline of <section> is unknown; give a <tube>")
    if beam.shear_coefficient is not None and beam.section.shear_area_y is not None:
        raise place.error(f"{label} has a shear_coefficient and shear areas; leave one of them")
    try:
        shear_areas = beam.shear_areas
    except ArgumentError as error:
        raise place.error(f"{label}: {error}") from None
    if beam.y_axis is None and not (beam.section.is_isotropic and math.isclose(*shear_areas, rel_tol=1e-12)):
        raise place.error(
            f'{label} has a section that bends differently about y and z: write y_axis="x y z", the '
            "direction of the section's y (a rectangle's width) in the link's frame"
        )


def _check_end(beam: Beam, name: str, end: BeamEnd, connections: Collection[str]) -> None:
    if end.joint not in connections:
        raise beam.place.error(
            f"{beam.label} goes {name} the joint {end.joint!r}, which does not exist; {near_names(end.joint, connections)} "
            "(or is its <joint> or <loop> missing?)"
        )
    if end.side not in (None, "parent", "child"):
        given = f"{end.joint}:{end.side}"
        raise beam.place.error(f"{name}={given!r} of {beam.label} must end in ':parent' or ':child', not {end.side!r}")


def check_pairs(beams: Sequence[Beam]) -> None:
    """Check that the beams of one link are on different spans, and have their mass in the same way."""
    for other, beam in itertools.combinations(beams, 2):
        if other.link != beam.link:
            continue
        if (other.start, other.end) == (beam.start, beam.end):
            raise beam.place.error(
                f"two beams on the same span: {beam.label} and the beam {other.name!r} (see {other.place}); give them "
                "different from and to"
            )
        if (other.density is None) != (beam.density is None):
            raise beam.place.error(
                f"the beams of link {beam.link!r} must all give a density or none of them (see {other.place}), because a "
                "density replaces the link's <inertial>"
            )


# ---- elastic joints ------------------------------------------------------------------------------------------------------


def _stiffness(stiffness: JointStiffness, connections: Mapping[str, Joint | Loop], actuated: Collection[str]) -> JointStiffness:
    """Return a stiffness after its checks; three infinite values count as missing."""
    check_reference(stiffness.place, stiffness.label, "joint", stiffness.joint, connections)
    joint = connections[stiffness.joint]
    locked = stiffness.joint in actuated or (isinstance(joint, Joint) and joint.mimic is not None)
    groups: dict[str, Sequence[float] | None] = {"linear": stiffness.linear, "angular": stiffness.angular}
    if stiffness.matrix is not None:
        if any(groups.values()):
            raise stiffness.place.error(f"{stiffness.label} has a matrix and also linear or angular; give either")
        diagonal = full_matrix(stiffness.matrix).diagonal().tolist()
        groups = {"linear": diagonal[:3], "angular": diagonal[3:]}
    for group, values in groups.items():
        if values is not None and all(map(math.isinf, values)):
            stiffness = replace(stiffness, linear=None) if group == "linear" else replace(stiffness, angular=None)
        elif values is not None:
            _check_group(stiffness, group, values, joint, locked)
    if stiffness.drive is not None and stiffness.joint not in actuated:
        reason = f"{stiffness.label} has the attribute drive, but {stiffness.joint!r} is not actuated"
        raise stiffness.place.error(f"{reason}; name it in a <transmission>, or drop drive")
    return stiffness


def _check_group(stiffness: JointStiffness, group: str, values: Sequence[float], joint: Joint | Loop, locked: bool) -> None:
    """Check the three linear or angular stiffnesses of a joint, which may be zero along the joint's freedoms only.

    If a direction of motion is not an axis of the joint's frame, all three values must be finite and positive.
    """
    kind, what = joint.of_type, f"{group}{' diagonal of the matrix' * (stiffness.matrix is not None)} of {stiffness.label}"
    axes = kind.slides if group == "linear" else kind.turns
    free = 0 if locked else axes.count
    if free == 3 or (free and all(0 < value < math.inf for value in values)):
        return
    if free and axes is Axes.BOTH:
        right = "three finite numbers greater than zero" + ", or be left out" * (stiffness.matrix is None)
        raise stiffness.place.error(f"{what} must be {right}, because a {joint.type} joint's axes are not those of one frame")
    constrained, where = {0, 1, 2}, {"linear": "along", "angular": "about"}
    if free:
        beside = [math.hypot(*(value for k, value in enumerate(joint.axis) if k != index)) for index in range(3)]
        along = next((index for index in range(3) if beside[index] <= _ALIGNED), None)
        if along is None:
            motion = "slides along" if group == "linear" else "turns about"
            raise stiffness.place.error(
                f"{joint.name!r} {motion} an axis that is none of its frame's axes, so that {what} mixes "
                "free and constrained directions: turn the joint's frame (<origin rpy>) so that its axis is one of the frame's "
                "axes, or give three finite numbers greater than zero"
            )
        constrained = {along} if free == 2 else constrained - {along}  # a planar joint constrains its normal direction
    for index in sorted(constrained):
        if values[index] == 0:
            reason = f"{what} is 0 {where[group]} {'xyz'[index]}, which {joint.name!r} constrains"
            raise stiffness.place.error(f"{reason}; give a number greater than zero, or inf for rigid")
