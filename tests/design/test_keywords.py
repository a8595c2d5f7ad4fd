"""Keywords that a function hands on to ``analyze``: those that are misspelt, and those that it chooses itself."""

import inspect

import package_robots
import pytest

import kinetostatics as ks


def test_the_function_that_was_called_is_named(tmp_path):
    robot = package_robots.robot("3rps")
    pose = robot.assemble()
    calls = {
        "sensitivities": lambda **given: ks.sensitivities(pose, **given),
        "spread": lambda **given: ks.spread(pose, {"rod_diameter": "1%"}, **given),
        "compensate": lambda **given: ks.compensate(pose, **given),
        "save_report": lambda **given: ks.save_report(pose, tmp_path / "report.html", **given),
        "optimize": lambda **given: ks.optimize("3rps", {"rod_diameter": "40mm,60mm"}, **given),
        "pareto": lambda **given: ks.pareto("3rps", {"rod_diameter": "40mm,60mm"}, **given),
        "calibrate": lambda **given: ks.calibrate(robot, {"dz": [0.0]}, ["rod_1"], **given),
        "plan_measurements": lambda **given: ks.plan_measurements(robot, ["rod_1"], 1, **given),
    }
    for name, call in calls.items():
        with pytest.raises(ks.ArgumentError, match=f"^{name} takes no 'gravitiy': did you mean 'gravity'"):
            call(gravitiy=(0, 0, 0))
    for name in ("optimize", "pareto", "calibrate", "plan_measurements"):
        with pytest.raises(ks.ArgumentError, match=f"^{name} takes no 'on_failure'"):
            calls[name](on_failure="raise")
    with pytest.raises(ks.ArgumentError, match=r"^calibrate takes no 'load': did you mean 'loads'"):
        calls["calibrate"](load=[0, 0, -500, 0, 0, 0])
    with pytest.raises(ks.ArgumentError, match=r"^spread takes no 'distribtion': did you mean 'distribution'"):
        calls["spread"](distribtion="uniform")
    with pytest.raises(
        ks.ArgumentError, match=r"^optimize takes no 'requirements': its own are robot, .* subject_to, .* of analyze$"
    ):
        calls["optimize"](requirements=["sag < 1mm"])
    assert not (tmp_path / "report.html").exists()


def test_every_public_function_tells_keywords_in_words():
    """Those that hand keywords on are looked at above; coordinates and values of files are told where they are read."""
    pytest.importorskip("matplotlib").use("Agg")
    pytest.importorskip("xarray")
    handing_on = {"sensitivities", "spread", "compensate", "save_report", "optimize", "pareto", "calibrate", "plan_measurements"}
    handing_on |= {"new_robot", "robot_text", "plot.line", "plot.slice", "plot.surface", "plot.workspace"}
    found = {name: getattr(ks, name) for name in ks.__all__}
    for title, module in (("indices", ks.indices), ("plot", ks.plot)):
        found |= {f"{title}.{name}": getattr(module, name) for name in module.__all__}
    found |= {"Robot.assemble": ks.Robot.assemble, "Robot.configuration": ks.Robot.configuration}
    functions = {name: item for name, item in found.items() if inspect.isfunction(item)}
    assert len(functions) > 50
    lacking = 0
    for name, function in functions.items():
        own = [item for item in inspect.signature(function).parameters.values() if item.kind is item.POSITIONAL_OR_KEYWORD]
        required = [item.name for item in own if item.default is item.empty]
        if required and "." not in name:
            lacking += 1
            with pytest.raises(ks.ArgumentError, match=rf"^{name} lacks {required[0]!r}.*: {name}\({required[0]}"):
                function()
            with pytest.raises(ks.ArgumentError, match=rf"^{name} takes no '{required[0]}e': did you mean '{required[0]}'"):
                function(**{f"{required[0]}e": None})
    assert lacking > 20
    for name, function in functions.items():
        if any(item.kind is item.VAR_KEYWORD for item in inspect.signature(function).parameters.values()):
            handing_on.remove(name)
            continue
        with pytest.raises(ks.ArgumentError, match=rf"^{name.rpartition('.')[2]} takes no 'gravitiy': "):
            function(gravitiy=0)
        assert function.__module__ != "kinetostatics.argument_checks" and function.__doc__
    assert not handing_on
    for name in ("point", "loads", "on_failure"):  # which it has
        with pytest.raises(ks.ArgumentError, match="analyze lacks 'configuration'"):
            ks.analyze(**{name: None})
    with pytest.raises(
        ks.ArgumentError, match=r"^analyze wants the names of its arguments besides configuration, load, .*: point"
    ):
        ks.analyze(None, (0,) * 6, (0, 0, -9.81), (0, 0, 0))
    with pytest.raises(ks.ArgumentError, match=r"^Payload takes no 'masss': did you mean 'mass'\?$"):
        ks.Payload(masss=3)
    with pytest.raises(ks.ArgumentError, match=r"^Gauge lacks 'direction': Gauge\(direction, point, frame, measures, sigma\)$"):
        ks.Gauge()


def test_what_does_the_same_is_told():
    robot = package_robots.robot("3rps")
    with pytest.raises(ks.ArgumentError, match=r"^sweep takes no 'tool': indices.at_point\(map, tool\) is the map"):
        ks.sweep(robot, platform={"z": [0.5]}, tool=(0, 0, 0.1))
    with pytest.raises(ks.ArgumentError, match=r"^verify takes no 'tool': .*analyze\(…\).at_point\(tool\)"):
        ks.verify(robot.assemble(), tool=(0, 0, 0.1))
    with pytest.raises(ks.ArgumentError, match=r"^analyze takes no 'laod': did you mean 'load'"):
        ks.analyze(robot.assemble(), laod=[0, 0, 1, 0, 0, 0])
    with pytest.raises(ks.ArgumentError, match=r"^assemble takes no 'plattform': did you mean 'platform'"):
        robot.assemble(plattform={"z": 0.5})
