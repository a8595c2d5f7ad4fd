"""The mistakes in units, by which numbers are far too large or too small: none is an error, and all are warned of."""

from dataclasses import replace

from guide_mistakes import Mistake, add, swap
from guide_mistakes_of_files import B_WHOLE, CIRCLE, LEFT
from guide_mistakes_of_robots import HEAVY, SECOND_MOTOR, joint, more

UNITS = tuple(replace(mistake, warns=True) for mistake in (
    Mistake('`<spring … free_length="150">`', "0.15.",
            more('<spring name="s" stiffness="1e-3" free_length="150"><predecessor link="ground"/>'
                 '<successor link="plate"><origin xyz="0.2 0 0"/></successor></spring>')),
    swap(CIRCLE, '<circle diameter="20"/>', "0.02."),
    swap(CIRCLE, '<circle diameter="2e-5"/>', "0.02."),
    swap(LEFT, LEFT.replace("210e9", "210"), "210e9.", '`<beam … youngs_modulus="210" …>`'),
    swap(LEFT, LEFT.replace('poisson_ratio="0.3"', 'shear_modulus="807e9" shear_coefficient="0.9"'), "80.7e9.",
         '`<beam … youngs_modulus="210e9" shear_modulus="807e9" …>`'),
    swap(LEFT, LEFT.replace("7850", "7.85"), "7850.", '`<beam … density="7.85">`'),
    swap(LEFT, LEFT[:-1] + ' thermal_expansion="12">', "12e-6.", '`<beam … thermal_expansion="12">`'),
    Mistake("all origins in mm", "Millimetres in xacro: `${300 * mm}`, with a property `mm`.",
            (("0 0 0.3", "0 0 300"), ("0.4 0 0", "400 0 0")) * 2),
    add('<joint_stiffness joint="a" drive="20"/>', "20e3, if it was meant in N·m/mrad."),
    add('<joint_stiffness joint="a" drive="1e15"/>', "inf, or leave it out."),
    Mistake("a load of 1 MN, or another slip in the units", "Look at moduli, diameters, masses, loads.",
            code="result = ks.analyze(pose, load=[0, 1e6, 0, 0, 0, 0])"),
    Mistake('`<origin xyz="0 0 0.3" rpy="0 90 0"/>` in b', "`${radians(90)}` in xacro.",
            ((B_WHOLE, B_WHOLE.replace('"0 0 0.3"', '"0 0 0.3" rpy="0 90 0"')),)),
    Mistake('`<limit lower="-90" upper="90" …/>` in a', "`${radians(90)}` in xacro.",
            (('lower="-1" upper="1"', 'lower="-90" upper="90"'),)),
    Mistake("a lamp on a driven slide of the plate, with `<limit lower=\"-50\" upper=\"50\" …/>`", "0.05.",
            more(joint("e", "plate", "lamp", 0.1, "prismatic", HEAVY, "0 0 1").replace(
                "</joint>", '<limit lower="-50" upper="50" effort="0" velocity="0"/></joint>')
                + SECOND_MOTOR.replace('"d"', '"e"'))),
    Mistake('`robot.assemble(actuators={"a": 10})`', "Radians.", code='robot.assemble(actuators={"a": 10}, on_failure="nan")'),
    Mistake('`robot.assemble(platform={"x": 20})`', "Metres.", code='robot.assemble(platform={"x": 20}, on_failure="nan")'),
    Mistake("`ks.analyze(pose).at_point((0, 0, 200))`", "Metres; so it is with `tool=` everywhere.",
            code="robot = ks.load_robot(file)\nks.analyze(robot.assemble()).at_point((0, 0, 200))"),
    Mistake('`ks.optimize("3rps", {"rod_diameter": "40:120"})`', "Metres, or `\"40mm:120mm\"`.",
            code='robot = ks.optimize("3rps", {"rod_diameter": "40:120"}, starts=1).robot'),
    Mistake('`ks.load_robot("3rps", {"rod_diameter": 80})`', 'Metres, or `"80mm"`.',
            code='robot = ks.load_robot("3rps", {"rod_diameter": 80})'),
    Mistake('`ks.optimize("3rps", {"rod_diameter": "4cm:5cm"}, subject_to=["sag < 20"])`', '`"sag < 20um"`.',
            code='robot = ks.optimize("3rps", {"rod_diameter": "4cm:5cm"}, subject_to=["sag < 20"], starts=1).robot'),
    Mistake("`ks.tolerances(pose, length=0.5, angle=0.5)`", 'Metres and rad, or `"0.5mm"` and `"0.5mrad"`.',
            code="ks.tolerances(pose, length=0.5, angle=0.5)"),
))  # fmt: skip
