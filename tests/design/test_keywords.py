"""Keywords that a function hands on to ``analyze``: those that are misspelt, and those that it chooses itself."""

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
    assert not (tmp_path / "report.html").exists()
