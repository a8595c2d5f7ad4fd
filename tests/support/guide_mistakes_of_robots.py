"""The mistakes that are answered when a robot is built, posed and analysed, in the order of the guide's tables."""

from dataclasses import replace

from guide_mistakes import Mistake, add, code, swap
from guide_mistakes_of_files import B_WHOLE, CIRCLE, INERTIA, JOINT_B, LEFT, LOOP, LOOP_AXIS, MOTOR, RIGHT

LEFT_BEAM = f"{LEFT}\n    {CIRCLE}\n  </beam>"
RIGHT_BEAM = f'{RIGHT}\n    <tube outer_diameter="0.03" inner_diameter="0.02"/>\n  </beam>'
SLIDE = '<joint name="slide" type="prismatic">{}<axis xyz="0 0 1"/><limit effort="0" velocity="0"/></joint>'
SUCCESSOR = '<successor link="plate"><origin xyz="0.4 0 0"/>'
HEAVY = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'


def joint(name: str, parent: str, child: str, z: float, kind: str = "fixed", link: str = "", axis: str = "") -> str:
    """Return a joint and its child, a link with something inside."""
    turns = f'<axis xyz="{axis}"/>' if axis else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z:g}"/>{turns}'
        f'</joint><link name="{child}">{link}</link>'
    )


def beam(link: str, ends: str, more: str = "") -> str:
    """Return a beam."""
    return f'<beam link="{link}" {ends} youngs_modulus="210e9" poisson_ratio="0.3" density="7850"{more}>{CIRCLE}</beam>'


def telescope(axis: str, ends: str = 'from="a" to="b"', more: str = "") -> tuple[tuple[str, str], ...]:
    """Return what makes the left rod slide out of a cylinder, as one beam."""
    slide = SLIDE.format('<parent link="left"/><child link="rod"/><origin xyz="0 0 0.2"/>').replace("0 0 1", axis)
    rest = '<parent link="rod"/><child link="plate"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>'
    return ((B_WHOLE, f'{slide}<link name="rod"/>{JOINT_B}{rest}'), (LEFT_BEAM, beam("rod", ends, more)))


def more(text: str) -> tuple[tuple[str, str], ...]:
    """Return the swap that adds something at the end."""
    return (("</robot>", f"{text}</robot>"),)


NO_LOOP = ((LOOP, "<!--"), ("</loop>", "-->"))
BALL = '<loop name="f" type="spherical"><predecessor link="ear"/><successor link="plate"/></loop>'

SPANS = (
    Mistake("a beam without `from` and `to` on a link with three joints, as the lift's rear arm", "Name both ends.",
            ((LEFT, LEFT.replace(' from="a" to="b"', "")), *more(joint("e", "left", "ear", 0.3) + BALL))),
    Mistake("the `<loop>` left out, and no `from` and `to` in the right rod's beam", "Write the loop.",
            (*NO_LOOP, (RIGHT, RIGHT.replace(' from="d" to="c"', "")))),
    Mistake("the `<loop>` left out", "Write the loop.", NO_LOOP),
    swap(B_WHOLE, B_WHOLE.replace('parent link="left"', 'parent link="right"'), "Write it.", '`<parent link="right"/>` in b'),
    Mistake("a beam without `from` and `to` on a post that leads nowhere", "Name both ends; its tip needs a joint, to a link of "
            "its own.", more(joint("e", "ground", "post", 0.3) + beam("post", ""))),
    swap(LEFT, LEFT.replace('to="b"', 'to="d"'), "A beam lies on one link: make a second beam.",
         '`<beam link="left" … to="d" …>`'),
    Mistake('`<origin xyz="0 0 0"/>` in b, so that b is at a', "The beam is as long as its joints are apart.",
            ((B_WHOLE, B_WHOLE.replace("0 0 0.3", "0 0 0")),)),
    swap(LEFT, LEFT[:-1] + ' y_axis="0 0 1">', "It runs along z: 1 0 0 or 0 1 0.", '`<beam … y_axis="0 0 1">`'),
    Mistake('`<beam … y_axis="0 0 1">`, telescopic along z', "1 0 0 or 0 1 0.", telescope("0 0 1", more=' y_axis="0 0 1"')),
    Mistake('`<axis xyz="0 1 1"/>` in the prismatic joint of a telescope along z', "Let the rod slide along itself; or make it "
            "two beams.", telescope("0 1 1")),
    Mistake("a lamp that hangs on the middle of the left rod", "As with the lift's rear arm, above.",
            more(joint("e", "left", "lamp", 0.1, "continuous", HEAVY, "0 1 0"))),
    Mistake("a beam that begins at a joint on the middle of the left rod, and lies on a link beyond", "Split the left rod there.",
            more(joint("e", "left", "ear", 0.3) + joint("f", "left", "lug", 0.15) + joint("g", "ear", "tip", 0.1)
                 + beam("ear", 'from="f" to="g"'))),
    Mistake("a beam between two bolts in one rigid plate", "It cannot bend: leave it out.",
            more(joint("e", "plate", "bar", 0.1) + joint("f", "plate", "g1", 0) + joint("g", "plate", "g2", 0.1)
                 + beam("bar", 'from="f:parent" to="g:parent"'))),
)  # fmt: skip

SUCCESSOR = '<origin xyz="0.4 0 0"/></successor>'
SECOND_MOTOR = '<transmission name="m2"><joint name="d"/></transmission>'
SHIFTED = ((SUCCESSOR, SUCCESSOR.replace("0.4 0 0", "0.4 0.01 0")),)
ROUNDED = ((SUCCESSOR, SUCCESSOR.replace("0.4 0 0", "0.4 0.00001 0")),)

POSES = (
    code('robot.assemble(actuators={"a": 0.1}, platform={"x": 0.2})', "Actuators, or platform."),
    code('robot.assemble(actuators={"motor": 0.1})', "The joint's name, not the transmission's."),
    code("robot.assemble(actuators={})", "Without `actuators=` all actuators are at zero."),
    code('robot.assemble(platform={"height": 0.3})', "x, y and z of o, and three of its orientation."),
    code('robot.assemble(platform={"x": 0.2, "z": 0.3})', "As many as the mobility; the others follow."),
    code('robot.assemble(platform={"ry": 0.1})', "Choose coordinates along which it moves."),
    code('robot.assemble(platform={"z": 0.29})', "Upright rods move the plate along x alone."),
    code('robot.assemble(platform={"x": 0.6})', "Out of reach: the rods are 0.3 m long."),
    code('robot.assemble(platform={"x": 1e12})', "A length in metres; numbers that large leave no digits to loops."),
    code('robot.assemble(actuators={"a": 2})', "At π/2 the rods are in line, and the parallelogram can fold: begin at a pose on "
         "the other side, from `robot.configuration(q)`."),
    Mistake('`<origin xyz="5 0 0"/>` at the loop\'s successor', "A length or a frame is wrong: draw it.",
            ((SUCCESSOR, SUCCESSOR.replace("0.4", "5")),), code="robot.assemble()"),
    Mistake('`robot.mobility` of such a robot', "As above.", ((SUCCESSOR, SUCCESSOR.replace("0.4", "5")),),
            code="robot.mobility"),
    Mistake("`<origin xyz=\"0.4 0.01 0\"/>` at the loop's successor", "One of the frames that are named, by as much as it says.",
            SHIFTED, code="robot.assemble()"),
    Mistake("`<origin xyz=\"0.4 0.00001 0\"/>` there", "Write a size once, as a property, and compute with it.",
            ROUNDED, code="robot.assemble()"),
    code("robot.configuration([0.1, 1, 0, 1, 0])", "`assemble` finds coordinates that close them."),
    Mistake("the coordinates of a pose in which a joint with `<mimic>` is not where it follows", "`assemble` heeds couplings.",
            ((B_WHOLE, B_WHOLE.replace(JOINT_B, JOINT_B + '<mimic joint="a" multiplier="-1"/>')),),
            code="robot.configuration([0, 1, 0.1, 1, 0])"),
    code('robot.assemble(platform={"x": "0.25 m"})', "Numbers in m and rad; the command line has units."),
    code("robot.assemble(platform=[0.25])", "Names and values."),
    code("robot.assemble(platform={0: 0.25})", "The coordinate's name."),
    code("robot.assemble(orientation=3)", "Leave it out for the rotation vector."),
    code('robot.configuration("zero")', "Pinocchio's coordinates, in the order of `robot.model.names`."),
    code('robot.assemble(platform={"x": nan})', "Look at the calculation behind it."),
    Mistake('`robot.assemble(actuators={"a": [0, 0.1], "d": [0, 0.1, 0.2]})`', "As many of each.", more(SECOND_MOTOR),
            code='robot.assemble(actuators={"a": [0, 0.1], "d": [0, 0.1, 0.2]})'),
    code('robot.assemble(platform={"x": 0.25}, orientation="XYX")', "Three different letters."),
    code('robot.assemble(on_failure="ignore")', "One of the two."),
    code("robot.assemble(tolerance=0)", "Leave it out for 1e-10."),
    code("robot.assemble(near=[0.1, 0, 0])", "A pose, not its coordinates."),
    code("robot.assemble(near=ks.load_robot(file).assemble())", "Load a robot once, and keep it."),
    code('robot.assemble(near=robot.assemble(actuators={"a": [0, 0.1]}))', "One pose, or as many as are asked for."),
    code("robot.configuration([0, 0])", "Pinocchio's coordinates, in the order of `robot.model.names`."),
    code('pose.frame("plat")', "A link's name."),
)  # fmt: skip

QUARTER = "1.5707963267948966"
#: the same with level rods
FOLDED = (
    ('<child link="left"/>\n', f'<child link="left"/><origin rpy="0 {QUARTER} 0"/>\n'),
    ('<origin xyz="0 0 0.3"/>\n', f'<origin xyz="0 0 0.3" rpy="0 -{QUARTER} 0"/>\n'),
    ('<origin xyz="0.4 0 0"/>\n', f'<origin xyz="0.4 0 0" rpy="0 {QUARTER} 0"/>\n'),
    (
        '<predecessor link="right"><origin xyz="0 0 0.3"/>',
        f'<predecessor link="right"><origin xyz="0 0 0.3" rpy="0 -{QUARTER} 0"/>',
    ),
)
LAMP = joint("e", "plate", "lamp", 0.1, "continuous", HEAVY.replace("<mass", '<origin xyz="0.1 0 0"/><mass'), "0 1 0")
CROOKED = (
    joint("e1", "ground", "cross", 0, "continuous", axis="1 0 0") + joint("e2", "cross", "ring", 0, "continuous", axis="0 1 0")
    + joint("e3", "ring", "strut", 0, "continuous", HEAVY.replace("<mass", '<origin xyz="0.1 0.1 0.1"/><mass'), "0 0 1")
    + '<loop name="ball" type="spherical"><predecessor link="strut"><origin xyz="0 0 0.3"/></predecessor>'
    '<successor link="plate"/></loop>'
)  # fmt: skip
DRIVEN_TELESCOPE = (*telescope("0 0 1"), *more(MOTOR.replace("motor", "m2").replace('"a"', '"slide"')))

STATICS = (
    Mistake("`<transmission>` left out", "As many actuators as the mobility, at least.", ((MOTOR, ""),), code="ks.analyze(pose)"),
    Mistake("rods level at zero, by `<origin rpy=…/>` in a and d, so that all hinges are in line", "Stay away from such poses; "
            "or drive d too.", FOLDED, code="ks.analyze(pose)"),
    Mistake("a lamp on a hinge of the plate, its centre of mass beside the hinge", "An actuator or a `<joint_stiffness>` in the "
            "hinge; or let it hang straight down.", more(LAMP), code="ks.analyze(pose)"),
    Mistake("the left rod a telescope, its slide driven too, and pushed in by more than its length", "Give the slide a "
            "`<limit>`, and poses within it.", DRIVEN_TELESCOPE,
            code="ks.analyze(robot.assemble(actuators={'a': 0, 'slide': -0.35}))"),
    Mistake("the same, and `.model` of that pose", "The same.", DRIVEN_TELESCOPE,
            code="robot.assemble(actuators={'a': 0, 'slide': -0.35}).model"),
    Mistake("a crooked strut, heavy, on a ball at either end", "A universal joint instead of one of the balls.", more(CROOKED),
            code="ks.analyze(robot.assemble(actuators={'a': 0.2}))"),
    code("ks.analyze(robot)", "Assemble it first."),
    code("ks.analyze(pose, load=[0, 0, -500])", "Force and moment."),
    code('ks.analyze(pose, load="500 N")', "Numbers in N and N·m."),
    code("ks.analyze(pose, load=[nan] * 6)", "Look at the calculation behind it."),
    code('ks.analyze(robot.assemble(actuators={"a": [0, 0.1]}), load=np.zeros((3, 6)))', "One load, or as many as poses."),
    code('ks.analyze(pose, frame="tool")', "One of the two."),
    code('ks.analyze(pose, on_failure="skip")', "One of the two."),
    code('ks.analyze(pose, engine="fast")', "One of the three; the default needs no thought."),
    code('ks.analyze(pose).report(hinge_axes={"limb_9": "x"})', "A limb's name."),
    code('ks.analyze(pose).report(hinge_axes={"limb_1": "z"})', "One of the two."),
    code("ks.analyze(pose, misfits=0.1)", 'Such as `{"left": {"length": 1e-4}}`.'),
    code('ks.analyze(pose, misfits={"rod": {"length": 1e-4}})', "A joint, loop or beam."),
    code('ks.analyze(pose, misfits={"left": 1e-4})', 'Such as `{"length": 1e-4}`.'),
    code('ks.analyze(pose, misfits={"left": {"temperature": 10}})', "As it says."),
    code('ks.analyze(pose, misfits={"b": [0, 0, 1e-4]})', "Displacement and rotation."),
    code('ks.analyze(pose, misfits={"b": {"shift": [0, 0, 1e-4]}})', "All in one twist."),
    code('ks.analyze(pose, misfits={"b": {"twist": [0] * 6, "frame": "link"}})', "One of the two."),
    code('ks.analyze(pose, misfits={"b": "loose"})', "Numbers."),
    code('ks.analyze(pose, misfits={"b": [nan] * 6})', "Look at the calculation behind it."),
    code("ks.compensate(robot)", "Assemble it first."),
    code('ks.compensate(pose, coordinates="z")', 'Such as `("z",)`.'),
    code(
        'ks.compensate(ks.load_robot("3rps").assemble(), coordinates=("x", "y", "z"), tool=(0, 0, 0))',
        "A longer tool, or other coordinates.",
    ),
    code('ks.compensate(pose).save("corrected.xlsx")', "One of the two."),
    code('ks.compensate(pose).to_dataset({"x": [0, 0.1]})', "As many values along each axis as the batch has."),
    code('ks.analyze(pose).actuator_forces["b"]', "An actuator's name."),
    code('description.beams["rod"]', "A beam's name."),
    code("ks.analyze(pose, loads=[0, 0, -5, 0, 0, 0])", 'Such as `{"plate": [0, 0, -5, 0, 0, 0]}`; for the platform `load=`.'),
    code('ks.analyze(pose, loads={"rod": [0, 0, -5, 0, 0, 0]})', "A link, not a joint."),
    code('ks.analyze(pose, loads={"plate": [0, 0, -5]})', "Force and moment."),
    code('ks.analyze(pose, loads={"plate": ks.LinkLoad([0, 0, -5, 0, 0, 0], frame="plate")})', "One of the two."),
    code('ks.analyze(pose, loads={"left": ks.LinkLoad([0, 0, -5, 0, 0, 0], (0, 0, 0.15))})', "As it says."),
    Mistake('`loads={"lamp": …}`, on a lamp without mass that hangs on the middle of the left rod', "As it says.",
            more(joint("e", "left", "lamp", 0.1, "continuous", "", "0 1 0")),
            code='ks.analyze(pose, loads={"lamp": [0, 0, -5, 0, 0, 0]})'),
    code('ks.analyze(ks.load_robot("3rps").assemble(), loads={"ball_1_x": [0, 0, -5, 0, 0, 0]})', "As it says."),
    Mistake('`<spring … free_length="0.1">` between two points that fall together', "Move one of its ends.",
            more('<spring name="s" stiffness="500" free_length="0.1"><predecessor link="ground"><origin xyz="0.2 0 0.3"/>'
                 '</predecessor><successor link="plate"><origin xyz="0.2 0 0"/></successor></spring>'),
            code="ks.analyze(pose)"),
    Mistake("`<spring …>` with an end in the middle of the left rod", "As it says.",
            more('<spring name="s" stiffness="500" free_length="0.1"><predecessor link="ground"/>'
                 '<successor link="left"><origin xyz="0 0 0.15"/></successor></spring>'),
            code="ks.analyze(pose)"),
    code("ks.analyze(pose, payload=5.0)", "As it says."),
    code("ks.analyze(pose, payload=ks.Payload(-5.0))", "The mass that is carried."),
    code("ks.tolerances(robot)", "One pose at a time."),
    code('ks.tolerances(pose, by="stress")', "One of the three."),
    code("ks.tolerances(pose, length=0)", "Metres: 1e-4 is usual."),
)  # fmt: skip

IMPORTS = "from dataclasses import replace; from kinetostatics.description import *; from kinetostatics.sections import *; "


def python(source: str, cure: str, before: str = "") -> Mistake:
    """Return a mistake in a robot that is made in Python."""
    return Mistake(f"`{source}`", cure, code=f"{IMPORTS}{before}{source}")


def arm_text(more: str = "", inside: str = "", mass: str = HEAVY, effort: float = 9) -> str:
    """Return the plain URDF of an arm with two joints."""
    links = f'<link name="base"/><link name="upper">{mass}</link><link name="tool">{mass}</link>'
    limit = f'<axis xyz="0 1 0"/><limit effort="{effort:g}" velocity="1"/>'
    joints = (
        f'<joint name="one" type="revolute"><parent link="base"/><child link="upper"/>{limit}{inside}</joint>'
        f'<joint name="two" type="revolute"><parent link="upper"/><child link="tool"/><origin xyz="0 0 1"/>{limit}</joint>'
    )
    return f'<robot name="arm">{links}{joints}{more}</robot>'


def arm(more: str, cure: str, written: str, inside: str = "") -> Mistake:
    """Return the oddity of a plain URDF, an arm with two joints, which is loaded with its tool as the platform."""
    return Mistake(written, cure, text=arm_text(more, inside), code='robot = ks.load_robot(file, platform="tool")')


def extended(options: str, cure: str, file: str | None = None) -> Mistake:
    """Return a mistake in the extension of that arm."""
    source = f"ks.extend_robot(file{options and ', '}{options})"
    return Mistake(f"`{source}`", cure, text=file or arm_text(), code=source)


PYTHON = (
    code("ks.analyze(pose).beams['lef']", "A name of the list."),
    code("robot.description.joints['x']", "A name of the list."),
    python('ks.Robot("robot.urdf")', "`ks.load_robot` reads files."),
    python('ks.save_robot(description, None)', "A path."),
    python('description.links["arm"] = Link("arm")', '`description.with_link(Link("arm"))`.'),
    python('description.changed("rod", mass=1)', "A link, joint, loop, beam or elastic joint."),
    python('description.changed("left", diameter=0.03)', "`section=Tube.of(0.03)`."),
    python('description.changed("left")', "What, and to which value?"),
    python('description.without_beam("rod")', "A beam's name."),
    python('description.with_payload("plate", "left", mass=2)', "The payload is a new link."),
    python('ks.Robot(description.with_joint_stiffness(JointStiffness("b", drive="stiff")))', "A number."),
    python('ks.Robot(description.changed("b", origin=Origin(0.3)))', "A list or tuple."),
    python('ks.Robot(description.changed("plate", inertia=Inertia((1, 1, 1))))', "All six."),
    python('ks.Robot(description.changed("b", parent=3))', "A link's name."),
    python('ks.Robot(description.changed("left", section=0.02))', "`Tube.of(0.02)`."),
    python('ks.Robot(description.changed("right", section=replace(description.beams["right"].section, outer_diameter=0.05)))',
           "Sections are made anew."),
    python('ks.save_image(ks.analyze(robot.assemble()), "sag.jpg")', "`\"sag.png\"`."),
    python('ks.save_html(robot, "sag.html")', "The result: `ks.analyze(robot.assemble())`."),
    python('ks.engine_report("3rps")', '`ks.load_robot("3rps")`.'),
    python('ks.plot.save(3, "sag.svg")', "What `ks.plot.line(…)` returns."),
    python('ks.save_report(robot.assemble(), "sag.pdf")', "`\"sag.html\"`, printed from a browser."),
    python('ks.save_report(robot.assemble(), "sag.html", workspace=ks.indices.at_point(ks.sweep(robot), (0, 0, 0.1)))',
           "As it says; or a map of `ks.sweep` as it is."),
    python('ks.sweep("3rps", parameters={"joint_angle_max": 1}, parameter_units={"joint_angle_max": "m"})', "An angle, in rad."),
    python('ks.sweep(robot, outputs=["twists"])', "A variable of maps, see [Workspace maps](../../how_to/workspace.md)."),
    python('ks.sweep(robot, outputs=["spring_force"])', "What the robot has."),
    python('ks.indices.conditioning(ks.sweep(robot, outputs=["twist"]))', "As it says."),
    python('robot.assemble(actuators={"a": [0, 0.1]}).model', "`robot.assemble(actuators={\"a\": 0.1}).model`."),
    replace(swap('<loop name="c" type="continuous">', '<loop name="c" type="cylindrical">', "As it says."),
            written="`robot.constraint_models()`, the loop being cylindrical", code="robot.constraint_models()"),
    python("Tube.of(-0.02)", "A size above zero."),
    python('ks.Robot(replace(description, links={"arm": description.links["left"]}))', "`RobotDescription.of` takes lists."),
    python('RobotDescription.of("r", links=[], joints=[], platform="a", joint_stiffness=[JointStiffness("b"), '
           'JointStiffness("b")])', "One for each joint."),
    python('ks.Robot(description.changed("plate", extra="<visual>"))', "Whole elements."),
    python('ks.Robot(description.changed("plate", extra="blue"))', "Elements only."),
    python('ks.Robot(replace(description, attributes=(("the name", "x"),)))', "A name as XML has them."),
    python('ks.Robot(description.with_joint(Joint("b:child", "fixed", "left", "l2")).with_link(Link("l2"))'
           '.changed("left", end=BeamEnd("b", "child")))', "No colons in names."),
    python('Beam("left", Tube.of(0.02), Material(210e9)).shear_modulus', "`poisson_ratio` or `shear_modulus` of the material."),
    python('ks.save_robot(robot, folder / "none" / "x.urdf")', "Make the folder first."),
    replace(python('ks.save_robot(robot, "x\\0.urdf")', "The path was computed wrong."), ours="'x\\x00.urdf' cannot be written:"),
    python('ks.save_robot(robot, folder / "lift_table.urdf.xacro")', "Another name: plain URDF is written.",
           '(folder / "lift_table.urdf.xacro").write_text("<robot xmlns:xacro=…>"); '),
    extended('platform="tool"', "Its own platform stays.", arm_text('<platform link="tool"/>')),
    extended('platform="tool", base="upper"', "Its own base stays.", arm_text('<base link="base"/>')),
    extended('platform="tool", driven="one"', "`driven=[\"one\"]`."),
    extended('platform="tool", driven=["oen"]', "A joint's name."),
    extended('platform="tool", elastic="all"', "The word, or a mapping."),
    extended('platform="tool", elastic={"uper": "circle 20mm"}', "A link's name."),
    extended('platform="tool", elastic={"tool": "circle 20mm"}', "One that lies between two joints."),
    extended('platform="tool", elastic="suggested"', "Sections of your own.", arm_text(mass="")),
    extended('platform="tool", joint_stiffness="all"', "The word, or a mapping."),
    extended('platform="tool", joint_stiffness={"oen": 1e4}', "An actuator's name."),
    extended('platform="tool", joint_stiffness={"one": "soft"}', "A number."),
    extended('platform="tool", joint_stiffness="suggested"', "Numbers of your own.", arm_text(effort=0)),
    extended('platform="tool", parameters={"length": 2}', "A xacro has parameters."),
    replace(extended("", "A robot's file.", "<model/>"), written="`ks.extend_robot(…)` of another file than a robot's"),
)  # fmt: skip


#: A page that is too large until its numbers are rounded to 16 bits: what is large about it is only said to be so.
LARGE_PAGE = """
from unittest import mock
sizes = iter([6_000_000, 6_000_000, 1_000])
with mock.patch("kinetostatics.viewer.page.page_html", lambda scene: "." * next(sizes)):
    ks.save_html(ks.analyze(robot.assemble(actuators={"a": [0.0, 0.1]})), folder / "page.html")
"""

PUSHING = more(
    '<spring name="s" stiffness="0" free_length="0" preload="-100e3"><predecessor link="ground"><origin xyz="0.2 0 0.6"/>'
    '</predecessor><successor link="plate"><origin xyz="0.2 0 0"/></successor></spring>'
)

WARNINGS = tuple(replace(mistake, warns=True) for mistake in (
    swap(B_WHOLE, B_WHOLE.replace('<axis xyz="0 1 0"/>', ""), "Write it: here 0 1 0.", "`<axis>` left out in b"),
    swap(LOOP_AXIS, "</successor>", "Write it: here 0 1 0.", "`<axis>` left out in the `<loop>`"),
    Mistake("the `<loop>` and the right rod's beam left out", "Write the loop.", (*NO_LOOP, (RIGHT_BEAM, ""))),
    swap('<link name="left"/>', '<link name="left"><visuals/></link>', "Correct it, or leave it."),
    swap(B_WHOLE, f'{B_WHOLE}<limit lower="-1" upper="1" effort="0" velocity="0"/>', "Say revolute.",
         '`<limit lower="-1" upper="1" …/>` in a continuous joint'),
    add('<xacro:property name="pi" value="3"/>', "Another name.", xacro=True),
    swap(LEFT, LEFT.replace(' density="7850"', ""), "One of them; 0 for a massless beam.",
         '`density="7850"` left out of `<beam>`'),
    swap(LEFT, LEFT.replace('from="a" to="b"', 'from="b" to="a"'), "Swap them.", '`<beam … from="b" to="a" …>`'),
    Mistake("`<origin xyz=\"0.4 0.00001 0\"/>` at the loop's successor", "Write a size once, as a property, and compute with it.",
            ROUNDED),
    Mistake("rods level at zero, as above", "Begin elsewhere: poses are reached from the zero pose.", FOLDED),
    Mistake('`<spring … preload="-100e3">` above the plate', "-100, if it was meant so.", PUSHING,
            code="result = ks.analyze(pose)"),
    Mistake("the same at two poses", "So it is with all warnings that hold at some poses.", PUSHING,
            code='result = ks.analyze(robot.assemble(actuators={"a": [0, 0.1]}))'),
    Mistake('`<joint_stiffness joint="a" drive="200"/>`', "2e5, if that was meant.",
            more('<joint_stiffness joint="a" drive="200"/>'), code="result = ks.analyze(pose)"),
    swap(CIRCLE, '<circle diameter="0.15"/>', "A block is rigid: leave the beam out."),
    Mistake("5 kg in the `<inertial>` of a rod whose beam has a density", "Motors and fittings get links of their own.",
            (('<link name="left"/>', f'<link name="left">{HEAVY.replace("1", "5", 1)}</link>'),)),
    Mistake("1 kg in the `<inertial>` of a rod whose beam has `density=\"0\"`", "Leave the density out.",
            (('<link name="left"/>', f'<link name="left">{HEAVY}</link>'), (LEFT, LEFT.replace("7850", "0")))),
    Mistake('`<origin xyz="0.4 0 0.1"/>` at the loop\'s successor', "Where it is wrong is in the message; what closes it, in the "
            "picture.", ((SUCCESSOR, SUCCESSOR.replace("0.4 0 0", "0.4 0 0.1")),)),
    Mistake('`<origin xyz="0.9 0 0"/>` there', "Turn the frames so that zero is within reach.",
            ((SUCCESSOR, SUCCESSOR.replace("0.4 0 0", "0.9 0 0")),)),
    Mistake('`<limit lower="0.2" upper="1" …/>` in a', "Turn its frame, or widen the limits.", (('lower="-1"', 'lower="0.2"'),)),
    swap('<robot name="parallelogram">', "<robot>", "A name, if another is wanted."),
    swap(INERTIA, "", "Nothing; other tools, which compute motions, want it.", "`<inertia …/>` left out of `<inertial>`"),
    swap(INERTIA, INERTIA.replace(' ixy="0"', ""), "All six, for other tools: they drop an incomplete one, and its mass."),
    Mistake("a bolt with a `<mimic>` and a `<transmission>`", "Right, if a hand is held still; else the joint's type.",
            more(joint("e", "plate", "lamp", 0.1, "fixed", HEAVY).replace("</joint>", '<mimic joint="a"/></joint>')
                 + SECOND_MOTOR.replace('"d"', '"e"'))),
    arm("", "`<transmission>` of those that have a motor.", "the plain URDF of an arm, without any `<transmission>`"),
    arm('<transmission name="t"><joint name="one"/></transmission>', "Others' `<transmission>`, if they have a motor.",
        "the same with one `<transmission>` for two joints"),
    arm('<transmission name="t"/>', "The joint's name goes inside.", "the same with `<transmission name=\"t\"/>`"),
    arm("", "The name of a driven joint.", 'the same with `<mimic joint="motor"/>`', '<mimic joint="motor"/>'),
    Mistake("both `<beam>` left out", "Make beams of what is slender.", ((LEFT_BEAM, ""), (RIGHT_BEAM, ""))),
    Mistake("all masses left out", "`<inertial>` and `density`.",
            ((' density="7850"', ""), (' density="7850"', ""), ("<inertial>", "<!--"), ("</inertial>", "-->"))),
    Mistake("no `<inertial>` of the plate", "Weigh what you can: gravity is most of the load.",
            (("<inertial>", "<!--"), ("</inertial>", "-->"))),
    Mistake("a drawn disc on a hinge of the plate, without `<inertial>`", "Its mass, or 0.",
            more(joint("e", "plate", "disc", 0.1, "continuous", '<visual><geometry><sphere radius="0.05"/></geometry></visual>',
                       "0 1 0"))),
    Mistake("a third rod, rigid, without `<inertial>`", "An `<inertial>`, or a `<beam>` with a density.",
            more(joint("e", "ground", "third", 0, "continuous", axis="0 1 0").replace('xyz="0 0 0"', 'xyz="0.2 0 0"')
                 + '<loop name="f" type="continuous"><predecessor link="third"><origin xyz="0 0 0.3"/></predecessor>'
                 '<successor link="plate"><origin xyz="0.2 0 0"/></successor><axis xyz="0 1 0"/></loop>')),
    Mistake("d driven too", "An actuator that follows another one is a `<mimic>`.", more(SECOND_MOTOR)),
    Mistake("a lamp on a driven hinge of the plate", "Right, if that is meant.", more(LAMP + SECOND_MOTOR.replace('"d"', '"e"'))),
    Mistake('`robot.assemble(actuators={"a": 1.2})`', "The numbers are right all the same.",
            code='result = ks.analyze(robot.assemble(actuators={"a": 1.2}))'),
    Mistake('`robot.assemble(actuators={"a": 1.56})`', "Stay away: rods and plate lie in one line.",
            code='result = ks.analyze(robot.assemble(actuators={"a": 1.56}))'),
    Mistake("`ks.analyze(pose, load=[0, 0, -20000, 0, 0, 0])`", "A thicker rod, or less of a load.",
            code="result = ks.analyze(pose, load=[0, 0, -20000, 0, 0, 0])"),
    Mistake("`ks.analyze(pose, load=[0, 0, -200000, 0, 0, 0])`", "`result.buckles` says it of every pose.",
            code="result = ks.analyze(pose, load=[0, 0, -200000, 0, 0, 0])"),
    Mistake("`ks.analyze(robot.assemble(tolerance=1e-3))`, the loop's successor at `0.4 0.00001 0`", "Compute sizes in xacro.",
            ROUNDED, code="result = ks.analyze(robot.assemble(tolerance=1e-3))"),
    Mistake('`ks.save_html(result, "page.html")` of a large robot at 1,000 poses that lie anywhere',
            "Fewer poses, or one path through them.", code=LARGE_PAGE),
    Mistake("`ks.calibrate(robot, …, [\"payload.mass\"])`, readings upwards", "Right signs; or the unknown that makes them.",
            code='robot = ks.load_robot("3rps")\nrows = {"z": [0.5, 0.6], "rx": [0.0] * 2, "ry": [0.0] * 2, "dz": [1e-6, 1e-6]}\n'
            'ks.calibrate(robot, rows, ["payload.mass"])'),
    Mistake("`ks.calibrate(robot, …)`, one row written twice", "Each measurement once; one repeated is hardly ever the same.",
            code='robot = ks.load_robot("3rps")\nrows = {"z": [0.5, 0.6, 0.5], "rx": [0.0] * 3, "ry": [0.0] * 3, '
            '"Fz": [-100.0, -200.0, -100.0], "dz": [-1e-6, -2e-6, -1e-6]}\nks.calibrate(robot, rows, ["rod_1"])'),
))  # fmt: skip
