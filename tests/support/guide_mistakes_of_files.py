"""The mistakes that the reader of robot files answers, in the order of the guide's tables."""

from dataclasses import replace

from guide_mistakes import Mistake, add, code, drop, swap, whole

JOINT_A = '<joint name="a" type="revolute">'
JOINT_B = '<joint name="b" type="continuous">'
JOINT_D = '<joint name="d" type="continuous">'
B_WHOLE = f'{JOINT_B}\n    <parent link="left"/><child link="plate"/>\n    <origin xyz="0 0 0.3"/>\n    <axis xyz="0 1 0"/>'
LIMIT = '<limit lower="-1" upper="1" effort="100" velocity="1"/>'
LOOP = '<loop name="c" type="continuous">'
LOOP_AXIS = '</successor>\n    <axis xyz="0 1 0"/>'
PLATFORM = '<platform link="plate"><origin xyz="0.2 0 0"/></platform>'
LEFT = '<beam link="left" from="a" to="b" youngs_modulus="210e9" poisson_ratio="0.3" density="7850">'
RIGHT = '<beam link="right" from="d" to="c" youngs_modulus="210e9" poisson_ratio="0.3" density="7850">'
CIRCLE = '<circle diameter="0.02"/>'
MOTOR = '<transmission name="motor"><joint name="a"/></transmission>'
MASS = '<mass value="3"/>'
INERTIA = '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.04"/>'
NOTHING_INSTALLED = """
from unittest.mock import patch
with patch("kinetostatics.files.bundled._prefixes", lambda: iter(())):
    ks.load_robot(file)
"""
D_ORIGIN = '<origin xyz="0.4 0 0"/>\n    <axis'


def many(count: int, item: str) -> str:
    """Return a text many times, with its number for #."""
    return "".join(item.replace("#", str(k)) for k in range(count))


def row_of_links(count: int) -> str:
    """Return links that are bolted to each other, the first one to the ground."""
    bolts = (f'<joint name="j{k}" type="fixed"><parent link="l{k - 1}"/><child link="l{k}"/></joint>' for k in range(1, count))
    first = '<joint name="j0" type="fixed"><parent link="ground"/><child link="l0"/></joint>'
    return many(count, '<link name="l#"/>') + first + "".join(bolts)


def in_b(inside: str, cure: str, kind: str = "continuous") -> Mistake:
    """Return the mistake of writing something into the joint b."""
    written = f'`<joint name="b" type="{kind}"> … {inside} …`'
    return swap(JOINT_B, f'<joint name="b" type="{kind}">{inside}', cure, written)


def in_loop(kind: str, inside: str, cure: str) -> Mistake:
    """Return the mistake of writing something into the loop, which is of another type and has no ``<axis>``."""
    start = f'<loop name="c" type="{kind}">{inside}'
    return Mistake(f"`{start} …`", cure, ((LOOP, start), (LOOP_AXIS, "</successor>")))


def in_beam(old: str, new: str, cure: str) -> Mistake:
    """Return a mistake in the attributes of the left beam."""
    written = f"`<beam … {new} …>`" if new else f"`{old.strip()}` left out of `<beam>`"
    return swap(LEFT, LEFT.replace(old, new), cure, written)


def stiffness(attributes: str, cure: str) -> Mistake:
    """Return the mistake of a joint stiffness."""
    return add(f'<joint_stiffness joint="b"{attributes}/>', cure)


def link(name: str, cure: str, written: str = "") -> Mistake:
    """Return a mistake in an expression of xacro, which is to give a name."""
    return add(f'<link name="{name}"/>', cure, written or f"`{name}`", xacro=True)


FILES = (
    code('ks.load_robot(folder / "none.urdf")', "Relative paths start at the current folder.", "`kinetostatics check none.urdf`"),
    code("from kinetostatics.files.bundled import robot_path; robot_path(folder)", "Name the file in it.",
         "`kinetostatics check .`"),
    code('ks.load_robot("3prss")', "A path, or one of the names in `ks.robots()`."),
    code("ks.load_robot(3)", "A path, or one of the names."),
    code("from kinetostatics.files.bundled import copy_robots; copy_robots(['dleta'])", "`kinetostatics robots` lists them.",
         "`kinetostatics robots --copy dleta`"),
    code("from kinetostatics.files.bundled import copy_robots; copy_robots('delta')", "`['delta']`", "`copy_robots('delta')`"),
    code("from kinetostatics.files.bundled import copy_robots; (folder / 'delta.urdf.xacro').write_text('');"
         " copy_robots(['delta'], folder)", "Copy to another folder.", "`kinetostatics robots --copy delta`, twice"),
    code('ks.load_robot("/dev/null")', "Pipes and devices are not read."),
    replace(code('ks.load_robot("robot\\0.urdf")', "The path was computed wrong."), ours="the file cannot be read:"),
    code("file.write_bytes(b' ' * 10_000_001); ks.load_robot(file)", "A robot file describes; leave data in other files.",
         "a file of 11 MB"),
    whole("", "an empty file", "Was it saved?"),
    whole("<urdf/>", "`<urdf>…</urdf>`", "Everything is inside `<robot name=…>`."),
    swap('<child link="left"/>', "<child link=left/>", "Quotes around every value; `&lt;` and `&amp;` for < and & inside them."),
    swap('<child link="left"/>', '<child link="left">', "Close it: `<child …/>`."),
    swap("</robot>", "", "End the file with it.", "`</robot>` left out"),
    add('<xacro:property name="l" value="1"/>', "Declare the prefix in `<robot>`.",
        "`<xacro:…>` in a file without `xmlns:xacro`"),
    swap('<?xml version="1.0"?>', '<?xml version="1.0" encoding="klingon"?>', "Save it as UTF-8."),
    swap('<?xml version="1.0"?>', "<!DOCTYPE robot>", "Entities could read other files."),
    add("<a>" * 101 + "</a>" * 101, "No robot needs that.", "elements inside each other, 101 deep"),
    add("<a" + many(100_000, ' b#=""') + "/>", "Leave out what is not the robot's.", "100 001 elements and attributes"),
    swap('<robot name="parallelogram">', '<robot name="parallelogram" version="2">', "Leave `version` out."),
    swap(PLATFORM, '<platfrom link="plate"/>', "Other tools would skip it in silence."),
    add('<material name="m"/><material name="m"/>', "Leave one of them."),
)  # fmt: skip

XACROS = (
    code('ks.load_robot(file, parameters={"d": 0.03})', "Make the file a xacro with an `<xacro:arg>` of that name.",
         "`--set d=30mm` for a plain URDF"),
    add('<xacro:arg name="diameter" default="0.02"/>', "Use a name that the file has.", "`--set diametre=30mm`",
        'ks.load_robot(file, parameters={"diametre": 0.03})', xacro=True),
    add('<xacro:arg name="size" default="0.02"/><link name="l"><inertial><mass value="$(arg size)"/></inertial></link>',
        "A number, or one with a unit.", "`--set size=20mmm`", 'ks.load_robot(file, parameters={"size": "20mmm"})', xacro=True),
    add('<xacro:arg name="diameter" default="0.02"/>', "One number or text for each; load a robot for each size.",
        '`parameters={"diameter": [0.02, 0.03]}`', 'ks.load_robot(file, parameters={"diameter": [0.02, 0.03]})', xacro=True),
    add('<xacro:arg name="length" default="1"/><link name="$(arg lenght)"/>', "Declare it before it is used.", xacro=True),
    link("${length}", "Define it by `<xacro:property>`, above."),
    replace(link("${1 + }", "Expressions are written as in Python."), ours="xacro cannot expand this:"),
    add("<xacro:limb/>", "Define the macro above the call, or include its file.", xacro=True),
    add('<xacro:macro name="m" params="a"/><xacro:m/>', 'All parameters, or defaults: `params="a:=1"`.', xacro=True),
    add('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "An `<xacro:if>` must end it.", xacro=True),
    add('<xacro:property name="x" value="${x}"/><link name="${x}"/>', "Another name for the inner one.", xacro=True),
    add('<xacro:if value="maybe"/>', "True, False, or a number.", xacro=True),
    add('<xacro:include filename="none.xacro"/>', "Names are relative to the file that includes.", xacro=True),
    add('<xacro:include filename="$(find my robots)/arm.xacro"/>', "One word.", xacro=True),
    add('<xacro:include filename="$(find my_robots)/arm.xacro"/>', "Source the workspace, or install the package.", xacro=True,
        code=NOTHING_INSTALLED),
    add('<xacro:include filename="$(find example-robot-data)/arm.xacro"/>', "Pinocchio comes with it, where pip installed that.",
        code=NOTHING_INSTALLED, xacro=True),
    add("${xacro.load_yaml('none.yaml')}", "Names are relative to the file.", xacro=True),
    replace(add("${xacro.load_yaml('sizes.yaml')}", "Mend the YAML.", "`load_yaml` of a file with `rods: [1, 2`",
        "(folder / 'sizes.yaml').write_text('rods: [1, 2'); ks.load_robot(file)", xacro=True),
        ours="xacro cannot expand this:"),
    link("${math.hypott(3, 4)}", "Python's `math`, or the name alone: `hypot(3, 4)`."),
    link("${x.__class__}", "Another name."),
    add('<xacro:macro name="m" params="*inside">' + "<a>" * 60 + '<xacro:insert_block name="inside"/>' + "</a>" * 60
        + "</xacro:macro><xacro:m>" + "<a>" * 60 + "</a>" * 60 + "</xacro:m>", "Macros may be many, and not that deep.",
        "a macro that nests elements 60 deep, inside itself", xacro=True),
    add('<xacro:element xacro:name="my link"/>', "Letters, digits, `_`, `-`, `.`.", xacro=True),
    add("<a b=\"${'\\x01'}\"/>", "Backslashes in expressions are Python's.", xacro=True),
)  # fmt: skip

VALUES = (
    add("<link/>", "Everything is called something."),
    add('<link name=" "/>', "Give it a name."),
    add(f'<link name="{"x" * 201}"/>', "A shorter one.", "a name of 201 characters"),
    add('<link name="rod&#10;1"/>', "One line of letters, digits and signs."),
    swap('<child link="left"/>', '<child link="lfet"/>', "Capitals count; names from macros carry what the macro adds."),
    swap(MASS, '<mass value="3 kg"/>', "A bare number in SI units."),
    swap(MASS, '<mass value="nan"/>', "Look at the expression behind it."),
    swap(MASS, '<mass value="1e31"/>', "Look at the unit."),
    swap(MASS, '<mass value="-3"/>', "So are moments of inertia, densities and efforts."),
    swap(CIRCLE, '<circle diameter="0"/>', "For a rigid link leave the beam out."),
    swap(CIRCLE, '<circle diameter="1e-31"/>', "Look at the unit."),
    swap(D_ORIGIN, '<origin xyz="0.4, 0, 0"/>\n    <axis', "Blanks between numbers, no commas.", '`<origin xyz="0.4, 0, 0"/>`'),
    swap(D_ORIGIN, '<origin xyz="0.4 0"/>\n    <axis', "All three.", '`<origin xyz="0.4 0"/>`'),
    swap('<axis xyz="0 1 0"/>', "<axis/>", "Write it, or leave the element out for x."),
    swap('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', "1 0 0, 0 1 0 or 0 0 1 in the joint's frame."),
    swap(PLATFORM, '<platform link="plate" xyz="0.2 0 0"/>', "Inside: `<origin xyz=…/>`."),
    swap(PLATFORM, '<platform link="plate"><pose/></platform>', "Use what is known."),
    swap(MASS, f"{MASS}{MASS}", "One of each."),
    drop(MASS, "`<inertial>` is complete, or not there."),
)  # fmt: skip

TREES = (
    whole('<robot name="r"></robot>', '`<robot name="r"></robot>`', "Is the call of a macro missing?"),
    add('<link name="left"/>', "Hand macros a name to build theirs from."),
    swap(JOINT_A, '<joint name="a" type="hinge">', "Hinges are revolute, or continuous without limits."),
    swap(JOINT_A, '<joint name="a" type="universal">', "Two continuous joints with a massless link, or cut the loop here."),
    drop('<child link="left"/>', "Every joint has two sides."),
    swap('<child link="left"/>', '<child link="ground"/>', "Name the other link."),
    drop(LIMIT, "Or make it continuous."),
    swap(LIMIT, '<limit lower="1" upper="-1" effort="100" velocity="1"/>', "Swap them."),
    swap(LIMIT, '<limit lower="0.2" effort="100" velocity="1"/>', "Give both."),
    swap(LIMIT, '<limit lower="-1" upper="1"/>', "URDF wants effort and velocity; 0 will do."),
    swap(LIMIT, f"{LIMIT}<dynamics/>", "Leave it out.", "`<dynamics/>` in a joint"),
    swap(JOINT_B, '<joint name="b" type="planar">', "Turn the frame so that z is the plane's normal.",
         '`<joint name="b" type="planar">` with `<axis xyz="0 1 0"/>`'),
    swap(JOINT_A, f'{JOINT_A}<platform link="plate"/>', "Move it out.", '`<platform link="plate"/>` inside `<joint>`'),
    add('<joint name="e" type="continuous"><parent link="right"/><child link="plate"/></joint>',
        "The commonest of all: a tree has no loops."),
    add('<link name="hook"/>', "Join it to something, or take it out."),
    add('<joint name="e" type="fixed"><parent link="plate"/><child link="ground"/></joint>', "Cut the loop at one joint."),
    add(many(1001, '<link name="l#"/>'), "Join what is rigid into one link.", "1001 links"),
    add(many(84, '<link name="l#"/><joint name="j#" type="floating"><parent link="ground"/><child link="l#"/></joint>'),
        "Bolt what need not move.", "84 floating joints"),
    add(row_of_links(401), "Join what is rigid into one link.", "401 joints in a row"),
)  # fmt: skip

ROLES = (
    drop(PLATFORM, "Which link does the load act on?", "`<platform>` left out"),
    swap(PLATFORM, "", "The name of a link, as the file has it.", "`<platform>` left out, and `load_robot(…, platform=\"plat\")`",
         'ks.load_robot(file, platform="plat")'),
    add('<platform link="left"/>', "Bolt the second one to the first, by a fixed joint."),
    swap(PLATFORM, '<platform link="ground"/>', "Two links."),
    add('<base link="ground"/><base link="left"/>', "What else stands still is bolted to it, by fixed joints."),
    swap(PLATFORM, '<platform link="foot"/><link name="foot"/><joint name="bolt" type="fixed"><parent link="ground"/>'
         '<child link="foot"/></joint>', "A joint between them has the wrong type.",
         '`<platform link="foot"/>`, a link that is bolted to the ground'),
)  # fmt: skip

LOOPS = (
    swap(LOOP, '<loop name="c" type="hinge">', "The types are in [the robot file format](../robot_format.md#loop)."),
    swap(LOOP, '<loop name="a" type="continuous">', "Joints and loops share their names."),
    swap('<predecessor link="right">', '<predecessor link="plate">', "A loop joins two links."),
    drop('<predecessor link="right"><origin xyz="0 0 0.3"/></predecessor>', "Both sides.", "`<predecessor>` left out"),
    swap(LOOP, '<loop name="c" type="spherical">', "Leave it out.", '`<loop name="c" type="spherical">` with an `<axis>`'),
    swap(LOOP, f'{LOOP}<axis2 xyz="1 0 0"/>', "Leave it out."),
    swap(LOOP, '<loop name="c" type="universal">', "Its second axis is y, where it is left out.",
         '`<loop name="c" type="universal">` with `<axis xyz="0 1 0"/>`'),
    swap(LOOP, f'{LOOP}<limit lower="-1" upper="1"/>', "Say revolute."),
    in_loop("spherical", '<limit lower="-1" upper="1"/>', "`<cone angle=…/>`."),
    swap(LOOP, f'{LOOP}<cone angle="1"/>', "`<limit>`, of a revolute loop."),
    in_loop("spherical", '<cone angle="45"/>', "`${radians(45)}`."),
    add('<spring name="s" stiffness="500" free_length="0.1"><predecessor link="left"/><successor link="left"/></spring>',
        "A spring joins two links."),
    add(many(251, '<loop name="x#" type="spherical"><predecessor link="left"/><successor link="plate"/></loop>'),
        "The time to close them grows with their cube.", "251 loops"),
)  # fmt: skip

DRIVES = (
    swap(MOTOR, '<transmission name="motor"/>', "The joint's name goes inside."),
    swap(MOTOR, '<transmission name="m"><joint name="motor"/></transmission>', "The name of the joint, not of the motor."),
    Mistake('`<transmission …><joint name="c"/>`, a spherical loop', "Drive one of the limb's other joints.",
            ((LOOP, '<loop name="c" type="spherical">'), (LOOP_AXIS, "</successor>"), (MOTOR, MOTOR.replace('"a"', '"c"')))),
    add(MOTOR, "Once is enough.", f"`{MOTOR}`, twice"),
    Mistake('`<mimic joint="a"/>` in b, and `<transmission …><joint name="b"/>`', "It is driven with its master.",
            ((JOINT_B, f'{JOINT_B}<mimic joint="a"/>'),
             ("</robot>", '<transmission name="m2"><joint name="b"/></transmission></robot>'))),
    in_b('<mimic joint="a"/>', "Revolute, continuous or prismatic.", "floating"),
    in_b('<mimic joint="a" multiplier="0"/>', "Leave it out for 1."),
    in_b('<mimic joint="a" offset="1e10"/>', "Look at the unit."),
    in_b('<mimic joint="c"/>', "Cut the loop elsewhere, so that c is in the tree."),
    in_b('<mimic joint="b"/>', "Name the driven joint."),
    Mistake('`<mimic joint="e"/>` in b, where e is a bolt', "Name a joint that moves.",
            ((JOINT_B, f'{JOINT_B}<mimic joint="e"/>'),
             ("</robot>", '<link name="ear"/><joint name="e" type="fixed"><parent link="plate"/><child link="ear"/></joint>'
              "</robot>"))),
    in_b('<mimic joint="d"/>', "Drive d, or mimic a."),
    Mistake('`<mimic joint="d"/>` in b, and `<mimic joint="a"/>` in d', "All of them mimic the driven one.",
            ((JOINT_B, f'{JOINT_B}<mimic joint="d"/>'), (JOINT_D, f'{JOINT_D}<mimic joint="a"/>'))),
    stiffness("", "Joints are rigid without it."),
    add('<joint_stiffness joint="b" linear="1e8 1e8 1e8"/><joint_stiffness joint="b" angular="1e5 0 1e5"/>',
        "One element with all attributes."),
    stiffness(' drive="1e4"', 'A spring in a passive hinge about y: `angular="inf 1e4 inf"`.'),
    stiffness(' linear="1e8"', "Along x, y and z of the joint's frame."),
    stiffness(' linear="1e8 -1 1e8"', "`inf` for rigid."),
    stiffness(' linear="1e8 1e-31 1e8"', "Look at the unit."),
    stiffness(' linear="1e8 0 1e8"', "Only a freedom has 0."),
    Mistake('`<joint_stiffness joint="b" angular="1e5 0 1e5"/>`, and `<axis xyz="0 1 1"/>` in b', "The axis is to be x, y or z.",
            ((B_WHOLE, B_WHOLE.replace("0 1 0", "0 1 1")),
             ("</robot>", '<joint_stiffness joint="b" angular="1e5 0 1e5"/></robot>'))),
    Mistake('`<joint_stiffness joint="c" angular="0 0 1e5"/>`, and c a universal loop', "All three, or none.",
            ((LOOP, '<loop name="c" type="universal">'), (LOOP_AXIS, "</successor>"),
             ("</robot>", '<joint_stiffness joint="c" angular="0 0 1e5"/></robot>'))),
)  # fmt: skip

BEAMS = (
    in_beam('link="left"', 'link="plate"', "The elastic part of a platform becomes a link of its own."),
    in_beam('to="b"', 'to="elbow"', "A joint or loop; links do not count."),
    in_beam('to="b"', 'to="b:outer"', "Which of its two sides."),
    in_beam('to="b"', 'to="a"', "Two joints."),
    in_beam(' poisson_ratio="0.3"', "", "0.3 for steel, 0.33 for aluminium."),
    in_beam('poisson_ratio="0.3"', 'poisson_ratio="0.3" shear_modulus="81e9"', "One follows from the other."),
    in_beam('poisson_ratio="0.3"', 'poisson_ratio="0.7"', "0.2 … 0.4 for most materials."),
    in_beam('poisson_ratio="0.3"', 'shear_modulus="81e9"', "About 0.9 for solid, 0.5 for hollow sections."),
    drop(CIRCLE, "Say which.", "`<circle>` left out"),
    swap(CIRCLE, CIRCLE + CIRCLE, "A stepped rod is two links with a fixed joint between."),
    swap(CIRCLE, '<tube outer_diameter="0.02" inner_diameter="0.02"/>', "Diameters, not radii and walls."),
    swap(CIRCLE, '<rectangular_tube width="0.04" height="0.02" thickness="0.01"/>', "That is solid: `<rectangle>`."),
    swap(CIRCLE, '<rectangular_tube width="0.04" height="0.02" thickness="1e-20"/>', "Look at the unit."),
    swap(CIRCLE, '<rectangle width="0.04" height="2e-8"/>', "Look at the unit."),
    swap(CIRCLE, '<rectangle width="0.04" height="0.02"/>', 'Here `y_axis="0 1 0"`: the width lies along the hinges.'),
    swap(CIRCLE, '<section area="3e-4" I_y="8e-9" I_z="8e-9" J="16e-9"/>', "κ, or κA along y and z."),
    swap(CIRCLE, '<section area="3e-4" I_y="8e-9" I_z="8e-9" J="16e-9" shear_area_y="2e-4"/>', "Both."),
    Mistake('`<beam … shear_coefficient="0.9">` and `<section … shear_area_y="2e-4" shear_area_z="2e-4"/>`',
            "Shear areas are κA.",
            ((LEFT, LEFT[:-1] + ' shear_coefficient="0.9">'),
             (CIRCLE, '<section area="3e-4" I_y="8e-9" I_z="8e-9" J="16e-9" shear_area_y="2e-4" shear_area_z="2e-4"/>'))),
    swap(RIGHT, LEFT, "Is one of them a copy?", "two `<beam>` for the left rod"),
    Mistake('`<beam name="left" …>` on the right rod', "Leave `name` out, or choose another.",
            ((RIGHT, RIGHT.replace('link="right"', 'link="right" name="left"')),)),
    Mistake("two beams on one link, one of them without `density`", "All or none.",
            ((RIGHT, LEFT.replace('to="b"', 'to="b:child" name="more"').replace(' density="7850"', "")),)),
)  # fmt: skip
