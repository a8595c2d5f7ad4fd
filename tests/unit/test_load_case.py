"""Load cases: checked once, broadcast once; functions that hand keywords on to ``analyze`` list them."""

import inspect
import re
from typing import get_type_hints

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.analysis import analyzed
from kinetostatics.load_case import AnalysisKeywords, CalibrationLoads, FurtherKeywords, FurtherLoads, LoadCase, LoadKeywords

HANDING_ON = {
    ks.compensate: FurtherLoads,
    ks.sensitivities: AnalysisKeywords,
    ks.tolerances: AnalysisKeywords,
    ks.optimize: LoadKeywords,
    ks.pareto: LoadKeywords,
    ks.calibrate: CalibrationLoads,
    ks.plan_measurements: CalibrationLoads,
    ks.save_report: FurtherKeywords,
}


@pytest.mark.parametrize(("function", "keywords"), HANDING_ON.items(), ids=lambda part: part.__name__)
def test_signatures_list_the_keywords_that_are_handed_on(function, keywords):
    """They are those of ``analyze``, with its types, and none of them is among the function's own."""
    annotation = inspect.signature(function).parameters["analysis"].annotation
    assert annotation == f"Unpack[{keywords.__name__}]"
    of_analyze, own = get_type_hints(ks.analyze), inspect.signature(function).parameters
    for name, kind in get_type_hints(keywords).items():
        assert of_analyze[name] == kind and name not in own, name
    arguments = [np.zeros(0)] * sum(item.default is item.empty and item.kind is not item.VAR_KEYWORD for item in own.values())
    with pytest.raises(ks.ArgumentError, match=f"{function.__name__} takes no 'gravty'"):
        function(*arguments, gravty=(0, 0, -1.6))


def test_every_keyword_of_analyze_is_in_a_load_case_or_handed_on():
    of_analyze = set(inspect.signature(ks.analyze).parameters) - {"configuration"}
    assert of_analyze == {*get_type_hints(AnalysisKeywords), "motion"}
    assert {item.name for item in LoadCase.__dataclass_fields__.values() if item.init} == of_analyze - {"on_failure"}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"frame": "tool"}, "frame is 'tool'; it must be one of 'world', 'platform'"),
        ({"load": [0, 0, 1]}, "load has the shape (3,); its last axis must have 6 entries"),
        ({"gravity": [0, 0, np.nan]}, "gravity has entries that are not finite"),
        ({"point": [0, 0]}, "point has the shape (2,)"),
        ({"motion": {"z": 1}}, "motion= needs a Motion"),
        ({"engine": "fast"}, "engine"),
    ],
)
def test_load_cases_check_what_needs_no_robot(given, words):
    with pytest.raises(ks.ArgumentError, match=re.escape(words)):
        LoadCase(**given)


@pytest.mark.parametrize(
    ("given", "plain"),
    [({}, True), ({"load": np.ones(6), "gravity": np.ones(3)}, True), ({"engine": "numpy"}, True),
     ({"point": (0, 0, 1)}, False), ({"frame": "platform"}, False), ({"loads": {}}, False), ({"assembly_errors": {}}, False),
     ({"payload": ks.Payload(1)}, False)],
)  # fmt: skip
def test_plain_load_cases_have_load_and_gravity_only(given, plain):
    assert LoadCase(**given).is_plain is plain


def test_loads_are_broadcast_against_poses():
    """Every pair of load and pose is one of an analysis by itself, whatever gives the batch axes."""
    rng = np.random.default_rng(4)
    pose = package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.55, 0.6], "rx": 0.1, "ry": 0.0})
    case = LoadCase(
        rng.normal(size=(2, 1, 6)), rng.normal(size=(3, 3)), rng.normal(size=3), "platform",
        {"rod_1": {"length": rng.normal(size=(2, 1))}}, {"platform": rng.normal(size=6)}, ks.Payload(rng.uniform(size=3)),
    )  # fmt: skip
    loads, result = case.at(pose), analyzed(pose, case)
    assert (loads.shape, loads.count) == (result.shape, 6) == ((2, 3), 6)
    for k, (row, column) in enumerate(np.ndindex(2, 3)):
        mass, length = case.payload.mass[column], case.assembly_errors["rod_1"]["length"][row, 0]
        only = package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.55, 0.6][column], "rx": 0.1, "ry": 0.0})
        alone = ks.analyze(
            only, case.load[row, 0], case.gravity[column], point=case.point, frame="platform", loads=case.loads,
            payload=ks.Payload(mass), assembly_errors={"rod_1": {"length": length}},
        )  # fmt: skip
        np.testing.assert_allclose(result.twist[row, column], alone.twist, rtol=0, atol=1e-12 * np.abs(alone.twist).max())
        given = loads.take(slice(k, k + 1))
        np.testing.assert_allclose(given.load[:, 0], result.load[row, column], rtol=1e-14)
        assert [item.name for item in given.applied] == ["load on platform", "payload"]


def test_shapes_that_do_not_fit_are_listed():
    pose = package_robots.robot("3rps").assemble(platform={"z": [0.5, 0.55, 0.6], "rx": 0.1, "ry": 0.0})
    words = r"configuration \(3,\), load \(2,\), gravity \(\), loads on links and payload \(\)"
    with pytest.raises(ks.ArgumentError, match=words):
        ks.analyze(pose, np.zeros((2, 6)), payload=ks.Payload(1.0))
