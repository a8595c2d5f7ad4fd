"""The mistakes that are answered when parameters of a design are changed: sensitivities, tolerances, optima."""

from guide_mistakes import code

DESIGN = (
    code("ks.analyze(pose).at_point((0, 0))", "A point of the platform, from o in its axes."),
    code('ks.pareto(file, {"rod": "1mm:2mm"}, "mass")', 'Such as `("mass", "sag")`.'),
    code('ks.pareto(file, {"rod": "1mm:2mm"}, points=1)', "As it says."),
    code('ks.pareto("3rps", {"rod_diameter": "4cm:12cm"}, ("mass", "mass"))', "One of them another one."),
    code("ks.sensitivities(robot)", "Assemble it first."),
    code(
        "ks.sensitivities(pose, laod=[0, 0, -500, 0, 0, 0])", "So it is with all functions that hand arguments on to `analyze`."
    ),
    code(
        'ks.sensitivities(pose, by=["left.densty"])',
        "An argument of the file or a number of a part: `ks.compile(robot).parameters`.",
    ),
    code('ks.sensitivities(pose, by=["b.placement.y"])', "`ks.tolerances(pose)`."),
    code('ks.sensitivities(pose, of=["weight"])', "One of them."),
    code("ks.sensitivities(pose, of=[])", "What is differentiated?"),
    code('ks.sensitivities(pose, by=["left.density"], of=["mass"])["left.density"].twist', '`of=["mass", "twist"]`.'),
    code('ks.sensitivities(pose, by="rod")', 'Such as `["rod"]`.'),
    code(
        'ks.sensitivities(ks.Robot(robot.description.changed("left", density=1000.0)).assemble(), by=["d"])',
        "As it says, or a number of a part.",
    ),
    code('ks.sensitivities(pose, by=["left.density"])["left"]', "One that was looked at."),
    code('ks.spread(robot, {"left.density": "1%"})', "Assemble it first; one pose."),
    code('ks.spread(pose, {"left.density": "1%"}, load=[[0] * 6] * 2)', "One load."),
    code("ks.spread(pose, {})", "As it says."),
    code('ks.spread(pose, {"left.densty": "1%"})', "`ks.compile(robot).parameters` lists them."),
    code('ks.spread(pose, {"left.*": "1%", "*.density": "1%"})', "Each once."),
    code('ks.spread(pose, {"left.density": "1mm"})', "A unit of the same kind, or a part of it, `1%`."),
    code('ks.spread(pose, {"left.poisson_ratio": "1mm"})', "A plain number, or a part of it, `1%`."),
    code('ks.spread(pose, {"left.density": 0})', "As it says."),
    code('ks.spread(pose, {"a.placement.x": "1%"})', "Such as `0.1mm`."),
    code('ks.spread(pose, {"left.density": "1%"}, robots=0)', "As it says."),
    code('ks.spread(pose, {"b.placement.y": "0.1mm"})', "`ks.tolerances(pose)`."),
    code('ks.spread(pose, {"left.density": "300%"})', "Less."),
    code('ks.spread(pose, {"left.density": "1%"}).sampled("displacment")', "One of them."),
)

OPTIMA = (
    code('ks.optimize(robot, {"d": "1cm:2cm"})', '`"robot.urdf"`.'),
    code('ks.optimize("3rps", {})', "One parameter at least."),
    code('ks.optimize("3rps", "rod_diameter")', "A mapping."),
    code('ks.optimize(file, {"d": "1cm:2cm"})', "A plain URDF has numbers of parts: `left.outer_diameter`."),
    code('ks.optimize(file, {"rod": "1mm:2mm"}, requirements=["sag < 1mm"])', "`subject_to=`."),
    code('ks.optimize(file, {"left.diameter": "1cm:2cm"})', "One of its numbers: `ks.compile(robot).parameters`."),
    code('ks.optimize(file, {"left.density": "1cm:2cm"})', "A unit of the same kind."),
    code('ks.optimize(file, {"left.*": "1cm:2cm"})', "Numbers of one kind."),
    code('ks.optimize(file, {"left.density": "7000:8000", "*.density": "7000:8000"})', "Each once."),
    code('ks.optimize("3rps", {"rod_diameter": "12cm:4cm"})', "The smaller one first."),
    code('ks.optimize("3rps", {"rod_diameter": ["4cm"]})', "As it says."),
    code('ks.optimize("3rps", {"rod_diameter": "4kg:12kg"})', "A unit of the same kind."),
    code('ks.optimize("3rps", {"rod_diameter": "rods.csv"})', "A file that is there."),
    code('ks.optimize("3rps", {"base_radius": "standard_bars"})', "A catalogue with such a column."),
    code(
        'ks.optimize("3rps", {("rod_diameter", "base_radius"): "4cm:12cm"})',
        "Several parameters are chosen together from a catalogue.",
    ),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm", ("rod_diameter",): "standard_bars"})', "Each once."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to="sag < 20um")', '`["sag < 20um"]`.'),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["sga < 20um"])', "One of the quantities."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["sag = 20um"])', "As it says."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["sag < 20N"])', "A length."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["sag < 0um"])', "A limit above zero."),
    code(
        'ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["deflection_any_direction < 20um"])',
        "The force in brackets.",
    ),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, subject_to=["sag(500 N) < 20um"])', "Without brackets."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, minimize="least_rotational_stiffness")', "As a requirement."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, ["sag < 20um"])', "Requirements are `subject_to=`."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, starts=0)', "As it says."),
    code('ks.optimize("3rps", {"rod_diameter": "4cm:12cm"}, over={"z": "0.5"})', '`{"z": 0.5}`.'),
)
