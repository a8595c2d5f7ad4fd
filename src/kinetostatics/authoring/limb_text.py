"""The xacro macro of a limb: its joints, links, beams and actuators between base and platform.

Its geometry, with all joints at zero, consists of expressions of the file's arguments, so that the loops close for all values.
Axis z of a link's frame is along the link. Relative to the limb's frame, whose y is along the revolute axes, the link's frame is
rotated by the pitch about y, then by the roll about its own x. The inner end of a link is nearer to the base. The role of a beam
is crank, rod or cylinder.
"""

from __future__ import annotations

import textwrap
from collections.abc import Collection
from dataclasses import dataclass, field

from kinetostatics.authoring.limb_parts import LimbPoint, Skeleton
from kinetostatics.authoring.spherical import spherical_limb


@dataclass(frozen=True)
class LimbOptions:
    """Options of the text of a limb's macro.

    Attributes:
        macro, parameters: name and parameters of the macro.
        frame_lines: lines that call ``limb_frame``.
        guide_direction: expression of the direction of the carriage's guide in base axes.
        oblique: whether the last link may leave the plane normal to the revolute axes.
        prefixes: for each role, the beginning of the names of its section's arguments. With the role "cylinder", a telescope is
            made of a cylinder and a rod, both of constant length.
        widths: for each role, expressions of the drawn diameter, or of width and height.
        argument_names: names of the file's arguments. With ``crank_angle``, the rod's length is computed; without it, crank and
            rod have given lengths. With ``actuator_stiffness``, actuators are elastic. With ``crank_arc``, all axes meet in O.
    """

    macro: str
    frame_lines: tuple[str, ...]
    parameters: str
    guide_direction: str
    oblique: bool
    prefixes: dict[str, str]
    widths: dict[str, tuple[str, ...]]
    argument_names: Collection[str]


@dataclass
class _Walk:
    """The text of a limb, written from the base outwards, and the outermost link so far.

    Attributes:
        link: name of the outermost link.
        end: position of the next joint in the outermost link's frame.
        pitch, roll: expressions of the outermost link's angles; "0" if zero.
        last_joint: name of the joint at the outermost link's inner end.
        lines: the text so far.
        actuators: names of the actuated joints so far.
    """

    link: str = "foot_${i}"
    end: str = "0 0 0"
    pitch: str = "0"
    roll: str = "0"
    last_joint: str = ""
    lines: list[str] = field(default_factory=list)
    actuators: list[str] = field(default_factory=list)

    def write(self, *lines: str) -> None:
        self.lines += lines


def limb_macro(skeleton: Skeleton, options: LimbOptions) -> str:
    walk = _Walk()
    if "crank_arc" in options.argument_names:
        flat = {role: len(width) > 1 for role, width in options.widths.items()}
        walk.lines, walk.actuators = spherical_limb(skeleton, options.prefixes, flat)
    else:
        walk.write(*options.frame_lines, *_geometry(skeleton, options), "")
        _guide(skeleton, options, walk)
        for number in range(len(skeleton.points) - 1):
            _joint_and_link(skeleton, options, number, walk)
        last = skeleton.points[-1] if skeleton.points else LimbPoint("", None)
        if last.kind != "4S":  # the loops of its rods are already written
            _to_platform(skeleton, last, walk)
    for number, joint in enumerate(walk.actuators):
        letter = "abcdef"[number] if len(walk.actuators) > 1 else ""
        walk.write(f'<transmission name="drive_${{i}}{letter}"><joint name="{joint}"/></transmission>')
        if "actuator_stiffness" in options.argument_names:
            walk.write(f'<joint_stiffness joint="{joint}" drive="$(arg actuator_stiffness)"/>')
    body = textwrap.indent("\n".join(walk.lines), "    ")
    return f'  <xacro:macro name="{options.macro}" params="{options.parameters}">\n{body}\n  </xacro:macro>'


# ---- geometry ------------------------------------------------------------------------------------------------------


def _property(name: str, value: str) -> str:
    return f'<xacro:property name="{name}" value="${{{value}}}"/>'


def _geometry(skeleton: Skeleton, options: LimbOptions) -> list[str]:
    """Return the lines that define pitch, roll and length of each link."""
    if len(skeleton.points) < 2:
        return []
    lines: list[str] = []
    crank_angle = "crank_angle" in options.argument_names
    if skeleton.has_elbow:
        if crank_angle:
            lines += [
                "<!-- at zero the crank points outwards, crank_angle above the horizontal -->",
                _property("crank_pitch", "pi / 2 - crank_angle"),
            ]
        else:
            reach = "(rod_length**2 - limb_y**2)" if options.oblique else "rod_length**2"
            lines += [
                "<!-- at zero, the triangle of crank, rod and the line between their ends; elbow is the side of its bend -->",
                _property("line", "hypot(limb_x, limb_z)"),
                _property("cosine", f"(crank_length**2 + line**2 - {reach}) / (2 * crank_length * line)"),
                _property("bend", "acos(cosine) if fabs(cosine) &lt; 1 else xacro.fatal('crank and rod form no triangle')"),
                _property("crank_pitch", "atan2(limb_x, limb_z) + elbow * bend"),
            ]
        lines += [
            _property("along_x", "limb_x - crank_length * sin(crank_pitch)"),
            _property("along_z", "limb_z - crank_length * cos(crank_pitch)"),
        ]
        x, z = "along_x", "along_z"
    else:
        lines.append("<!-- at zero, the line from the limb's foot to its seat -->")
        x, z = "limb_x", "limb_z"
    lines.append(_property("rod_pitch", f"atan2({x}, {z})"))
    if not (skeleton.has_elbow and not crank_angle):
        length = f"sqrt({x}**2 + limb_y**2 + {z}**2)" if options.oblique else f"hypot({x}, {z})"
        lines.append(_property("rod_length", length))
    if options.oblique:
        lines.append(_property("rod_roll", "-asin(limb_y / rod_length)"))
    return lines


# ---- joints and links ----------------------------------------------------------------------------------------------


def _guide(skeleton: Skeleton, options: LimbOptions, walk: _Walk) -> None:
    if skeleton.guide is None:
        return
    if skeleton.guide_turns:
        walk.write(
            "<!-- the cylindrical joint: a slide along the limb's y, and a rotation about it -->",
            '<xacro:prismatic name="prismatic_${i}" parent="foot_${i}" child="carriage_${i}" axis="0 1 0" lower="${-stroke}"',
            '                 upper="${stroke}" effort="2000"/>',
            '<link name="carriage_${i}"><xacro:box_inertial mass="${carriage_mass}" x="0.1" y="0.1" z="0.1"/></link>',
        )
    else:
        walk.write(
            f'<xacro:guide i="${{i}}" name="prismatic_${{i}}" direction="${{{options.guide_direction}}}"',
            '             mass="${carriage_mass}" stroke="${stroke}"/>',
        )
    if skeleton.guide.actuated:
        walk.actuators.append("prismatic_${i}")
    walk.link, walk.last_joint = "carriage_${i}", "prismatic_${i}"


def _turn(angle: str, before: str = "0") -> str:
    """Return the expression of the difference ``angle`` − ``before``, without a term that is zero."""
    if angle == before:
        return "0"
    if before == "0":
        return f"${{{angle}}}"
    if angle == "0":
        return f"${{-{before}}}"
    return f"${{{angle} - {before}}}"


def _joint_and_link(skeleton: Skeleton, options: LimbOptions, number: int, walk: _Walk) -> None:
    """Write the joint at a point, and the link from this point to the next one."""
    point, span = skeleton.points[number], skeleton.spans[number]
    role = span.role
    pitch, roll = f"{role}_pitch", "rod_roll" if options.oblique and role == "rod" else "0"
    if span.kind == "rods":
        _rod_pair(options, walk)
        return
    child = {"telescope": "cylinder", "parallelogram": "head"}.get(span.kind, role) + "_${i}"
    inner = "turning_${i}" if span.turns else child
    _tree_joint(point, inner, pitch, roll, walk)
    if span.turns:
        walk.write(
            "<!-- the rotation of the cylindrical joint, about the line of the telescope -->",
            f'<link name="{inner}"/>',
            f'<xacro:revolute name="turn_${{i}}" parent="{inner}" child="{child}" axis="0 0 1"',
            '                lower="${-pi}" upper="${pi}"/>',
        )
        walk.last_joint = "turn_${i}"
    walk.link, walk.pitch, walk.roll = child, pitch, roll
    if span.kind == "telescope":
        _telescope(skeleton, options, number, walk)
    elif span.kind == "parallelogram":
        _parallelogram(options, walk)
    else:
        _rod(skeleton, options, number, walk)


def _tree_joint(point: LimbPoint, child: str, pitch: str, roll: str, walk: _Walk) -> None:
    """Write the joint at a point, with the link ``child`` at its outer side; the child has the angles ``pitch`` and ``roll``."""
    at = f'parent="{walk.link}" child="{child}"' + ("" if walk.end == "0 0 0" else f' xyz="{walk.end}"')
    turn, tilt = _turn(pitch, walk.pitch), _turn(roll)
    name = {"R": "revolute", "C": "turn", "U": "universal", "S": "spherical", "": "mount"}[point.kind] + f"_${{i}}{point.letter}"
    actuated = point.symbol is not None and point.symbol.actuated and point.kind == "R"
    if point.kind in ("R", "C"):
        limit = "drive_angle_max" if actuated else "joint_angle_max"
        walk.write(
            f'<xacro:revolute name="{name}" {at} rpy="0 {turn} 0"',
            f'                lower="${{-{limit}}}" upper="${{{limit}}}"' + (' effort="200"/>' if actuated else "/>"),
        )
        walk.last_joint = name
        if actuated:
            walk.actuators.append(name)
    elif point.kind == "U":
        cross = f'cross="cross_${{i}}{point.letter}"'
        if point.axes == "nx":
            order, first, second = 'first="y" second="x"', f'rpy="0 {turn} 0"', f' rpy2="{tilt} 0 0"' if roll != "0" else ""
            walk.last_joint = f"{name}_x"
        else:
            order, first = 'first="x" second="y"', f'rpy="0 {_turn("0", walk.pitch)} 0"'
            second = f' rpy2="0 {_turn(pitch)} 0"'
            walk.last_joint = f"{name}_y"
        walk.write(
            f'<xacro:universal name="{name}" {at} {cross} {order}',
            f'                 {first}{second} angle_max="${{joint_angle_max}}"/>',
        )
    elif point.kind == "S":
        walk.write(
            f'<xacro:spherical name="{name}" {at} ball="ball_${{i}}{point.letter}"',
            f'                 rpy="{tilt} {turn} 0" angle_max="${{joint_angle_max}}"/>',
        )
        walk.last_joint = f"{name}_z"
    else:
        xyz = f'xyz="{walk.end}" ' if walk.end != "0 0 0" else ""
        walk.write(
            f'<joint name="{name}" type="fixed">',
            f'  <parent link="{walk.link}"/><child link="{child}"/>',
            f'  <origin {xyz}rpy="0 {turn} 0"/>',
            "</joint>",
        )
        walk.last_joint = name


def _drawn(widths: tuple[str, ...], length: str, middle: str) -> str:
    attributes = f'material="steel" xyz="0 0 ${{{middle}}}"/>'
    if len(widths) == 1:
        return f'<xacro:draw_cylinder diameter="${{{widths[0]}}}" length="${{{length}}}" {attributes}'
    return f'<xacro:draw_box size="${{{widths[1]}}} ${{{widths[0]}}} ${{{length}}}" {attributes}'


def _rod(skeleton: Skeleton, options: LimbOptions, number: int, walk: _Walk) -> None:
    """Write a rod or crank of constant length, whose inner joint is already written."""
    role = skeleton.spans[number].role
    start, after = walk.last_joint, skeleton.points[number + 1]
    walk.write(
        f'<link name="{walk.link}">', f"  {_drawn(options.widths[role], f'{role}_length', f'{role}_length / 2')}", "</link>"
    )
    beam, walk.end = walk.link, f"0 0 ${{{role}_length}}"
    if after.kind == "4S":
        walk.write(
            "<!-- the elbow that holds the pair of rods is rigid, and has the limb's axes at zero -->",
            '<joint name="weld_${i}" type="fixed">',
            f'  <parent link="{walk.link}"/><child link="elbow_${{i}}"/>',
            f'  <origin xyz="{walk.end}" rpy="0 {_turn("0", walk.pitch)} 0"/>',
            "</joint>",
            '<link name="elbow_${i}">',
            '  <xacro:box_inertial mass="${elbow_mass}" x="0.02" y="${pair_width}" z="0.02"/>',
            '  <xacro:draw_cylinder diameter="0.02" length="${pair_width}" material="orange" rpy="${pi / 2} 0 0"/>',
            "</link>",
        )
        end, walk.link, walk.end, walk.pitch = "weld_${i}", "elbow_${i}", "0 0 0", "0"
    else:
        end = _inner_name(after, in_tree=number + 1 < len(skeleton.points) - 1)
    walk.write(f'<xacro:{options.prefixes[role]}_beam link="{beam}" start="{start}" end="{end}"/>')


def _inner_name(point: LimbPoint, *, in_tree: bool) -> str:
    """Return the name of the joint at a point; if it is a U or S in the tree, of the innermost of its revolute joints."""
    kind = {"R": "revolute", "U": "universal", "S": "spherical", "C": "cylindrical", "": "flange"}[point.kind]
    name = f"{kind}_${{i}}{point.letter}"
    if in_tree and point.kind == "U":
        return f"{name}_{'y' if point.axes == 'nx' else 'x'}"
    return f"{name}_x" if in_tree and point.kind == "S" else name


def _telescope(skeleton: Skeleton, options: LimbOptions, number: int, walk: _Walk) -> None:
    span, start = skeleton.spans[number], walk.last_joint
    role, end = span.role, _inner_name(skeleton.points[number + 1], in_tree=number + 1 < len(skeleton.points) - 1)
    length = f"{role}_length"
    width, beam = options.widths[role][-1], options.prefixes[role]
    slide = "telescope_${i}" if skeleton.guide is not None else "prismatic_${i}"
    if "cylinder" in options.prefixes:
        where, rod_length = f"cylinder_part * {length}", f"(1 - cylinder_part) * {length}"
        walk.write(
            "<!-- cylinder and rod have constant lengths; the locked actuator joins them rigidly -->",
            f'<link name="{walk.link}">',
            f"  {_drawn(options.widths['cylinder'], where, f'{where} / 2')}",
            "</link>",
        )
        middle = f"{rod_length} / 2"
        walk.end = f"0 0 ${{{rod_length}}}"
    else:
        walk.write(
            "<!-- massless: the beam below is the whole telescope, whose length depends on the slide -->",
            f'<link name="{walk.link}">',
            f'  <xacro:draw_cylinder diameter="${{1.3 * {width}}}" length="${{{length} / 2}}" material="blue"',
            f'                       xyz="0 0 ${{{length} / 4}}"/>',
            "</link>",
        )
        where, rod_length, middle = length, f"0.75 * {length}", f"-0.375 * {length}"
        walk.end = "0 0 0"
    rod = f"{role}_${{i}}"
    is_actuated = span.slide is not None and span.slide.actuated
    effort = ' effort="2000"' if is_actuated else ""
    walk.write(
        f'<xacro:prismatic name="{slide}" parent="{walk.link}" child="{rod}" xyz="0 0 ${{{where}}}" lower="${{-stroke}}" '
        f'upper="${{stroke}}"{effort}/>',
        f'<link name="{rod}">',
        f"  {_drawn(options.widths[role], rod_length, middle)}",
        "</link>",
    )
    if "cylinder" in options.prefixes:
        walk.write(
            f'<xacro:{options.prefixes["cylinder"]}_beam link="{walk.link}" start="{start}" end="{slide}"/>',
            f'<xacro:{beam}_beam link="{rod}" start="{slide}" end="{end}"/>',
        )
    else:
        walk.write(f'<xacro:{beam}_beam link="{rod}" start="{start}" end="{end}"/>')
    if is_actuated:
        walk.actuators.append(slide)
    walk.link, walk.last_joint = rod, slide


def _rod_pair(options: LimbOptions, walk: _Walk) -> None:
    width, beam = options.widths["rod"][-1], options.prefixes["rod"]
    walk.write(
        "<!-- two rods between spherical joints: they keep their far ends parallel to this one -->",
        f'<xacro:rod_pair i="${{i}}" link="{walk.link}" width="${{pair_width}}" pitch="${{rod_pitch}}" length="${{rod_length}}"',
        f'                diameter="${{{width}}}" angle_max="${{joint_angle_max}}"/>',
        *(f'<xacro:{beam}_beam link="rod_${{i}}{s}" start="upper_${{i}}{s}_z" end="lower_${{i}}{s}"/>' for s in "ab"),
    )


def _parallelogram(options: LimbOptions, walk: _Walk) -> None:
    width, beam = options.widths["rod"][-1], options.prefixes["rod"]
    walk.write(
        '<link name="head_${i}"><xacro:box_inertial mass="${head_mass}" x="0.02" y="${pair_width}" z="0.02"/></link>',
        '<xacro:parallelogram i="${i}" width="${pair_width}" length="${rod_length}" angle_max="${joint_angle_max}"',
        f'                     thickness="${{{width}}}"/>',
        '<link name="tail_${i}">',
        '  <xacro:box_inertial mass="${head_mass}" x="0.02" y="${pair_width}" z="0.02" xyz="0 ${-pair_width / 2} 0"/>',
        "</link>",
        *(f'<xacro:{beam}_beam link="bar_${{i}}{s}" start="upper_${{i}}{s}" end="lower_${{i}}{s}"/>' for s in "ab"),
    )
    walk.link, walk.end = "tail_${i}", "0 ${-pair_width / 2} 0"


def _to_platform(skeleton: Skeleton, point: LimbPoint, walk: _Walk) -> None:
    """Write the loop that connects the limb's last link to the platform."""
    end = "${limb_x} ${limb_y} ${limb_z}" if len(skeleton.points) < 2 else walk.end
    at = f'link="{walk.link}" platform="seat_${{i}}" xyz="{end}"'
    back = f"0 {_turn('0', walk.pitch)} 0"
    name, limit = _inner_name(point, in_tree=False), 'angle_max="${joint_angle_max}"'
    if point.kind == "R":
        walk.write(f'<xacro:revolute_loop name="{name}" {at} rpy="{back}" {limit}/>')
        if point.symbol is not None and point.symbol.actuated:
            walk.actuators.append(name)
    elif point.kind == "C":
        walk.write(f'<xacro:cylindrical_loop name="{name}" {at} rpy="{back}"/>')
    elif point.kind == "U" and point.axes == "nx":
        walk.write(f'<xacro:universal_loop name="{name}" {at} rpy="{back}"')
        walk.write(f'                      axis="0 1 0" axis2="1 0 0" {limit}/>')
    elif point.kind == "U":
        walk.write(
            f'<xacro:universal_loop name="{name}" {at} rpy="{_turn("0", walk.roll)} 0 0" rpy2="0 {_turn(walk.pitch)} 0"',
            f'                      axis="1 0 0" axis2="0 1 0" {limit}/>',
        )
    elif point.kind == "S":
        walk.write(f'<xacro:spherical_loop name="{name}" {at} rpy2="{_turn(walk.roll)} {_turn(walk.pitch)} 0" {limit}/>')
    else:
        walk.write(f'<xacro:fixed_loop name="{name}" {at} rpy="{back}"/>')
