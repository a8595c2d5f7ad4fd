"""The mistakes that are answered when parameters of a design are changed: sensitivities, tolerances."""

from guide_mistakes import code

DESIGN = (
    code('ks.pareto(file, {"rod": "1mm:2mm"}, "mass")', 'Such as `("mass", "sag")`.'),
    code('ks.pareto(file, {"rod": "1mm:2mm"}, points=1)', "As it says."),
    code("ks.sensitivities(robot)", "Assemble it first."),
    code('ks.sensitivities(pose, by=["rod"])', "A file that is a plain URDF has no parameters."),
    code('ks.sensitivities(pose, by="rod")', 'Such as `["rod"]`.'),
    code('ks.sensitivities(ks.Robot(robot.description.changed("left", density=1000.0)).assemble())', "As it says."),
    code('ks.sensitivities(pose)["rod"]', "A parameter of the file."),
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
