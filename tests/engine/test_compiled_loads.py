"""Loads on links and payloads by compiled code: they are inputs of it, and places that are loaded belong to its structure."""

from functools import partial

import numpy as np
import package_robots
import pytest
import tapes
from tapes import differences

import kinetostatics as ks
from kinetostatics.engine import programs
from kinetostatics.engine.record import example_of, structure_of
from kinetostatics.engine.statics import CompiledStatics
from kinetostatics.statics.link_loads import AppliedLoad, LoadedPlaces
from kinetostatics.statics.springs import solve_with_springs

close = partial(tapes.close, tolerance=1e-10)


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("linear_delta")


@pytest.mark.parametrize("poses", [1, 700])
def test_both_engines_say_the_same_of_loads_and_payload(robot, poses):
    """A payload whose mass differs from pose to pose, and two loads on links; poses in reach and out of it."""
    x = np.linspace(-0.6, 0.6, poses) if poses > 1 else np.array([0.05])
    at = robot.assemble(platform={"x": x, "y": 0.1, "z": float(robot.assemble().platform["z"])}, on_failure="nan")
    loads = {
        "carriage_1": [10, -20, -30, 1, 2, 3],
        "platform": ks.LinkLoad([0, 5, -70, 0, 0, 0], point=(0.1, 0, 0), frame="link"),
    }
    given = {"payload": ks.Payload(np.linspace(1.0, 4.0, poses), (0.02, 0.01, -0.05)), "loads": loads, "load": [1, 2, 3, 0, 0, 0]}
    found, wanted = (ks.analyze(at, **given, engine=engine) for engine in ("compiled", "numpy"))
    np.testing.assert_array_equal(found.status, wanted.status)
    assert list(found.contributions)[-3:] == ["load on carriage_1", "load on platform", "payload"]
    assert (wanted.status < 2).sum() > min(poses - 1, 3) and (poses == 1 or 2 in wanted.status)
    close(found.twist, wanted.twist)
    close(found.stiffness, wanted.stiffness)
    for name in ("contributions", "actuator_forces", "joint_wrenches"):
        mine, other = getattr(found, name), getattr(wanted, name)
        assert list(mine) == list(other)
        close(np.stack([mine[key] for key in other]), np.stack([other[key] for key in other]))
    close(found.base_wrench, wanted.base_wrench)
    close(found.payload_coefficients.twist, wanted.payload_coefficients.twist)
    places = [key for key, item in programs._STATICS[robot.statics].items() if item.made is not None and key is not None]
    assert len(places) == 1 and [name for name, _ in places[0].loads] == ["load on carriage_1", "load on platform", "payload"]


def test_places_that_are_loaded_belong_to_the_structure_and_loads_do_not(robot):
    keys = {
        structure_of(robot.statics, places).key
        for places in (
            None,
            LoadedPlaces((("payload", ("platform",)),)),
            LoadedPlaces((("load on carriage_1", ("carriage_1",)),)),
            LoadedPlaces((("load on carriage_1", ("carriage_1",)), ("payload", ("platform",)))),
        )
    }
    assert len(keys) == 4
    assert LoadedPlaces.of(()) is None


def test_where_a_loaded_limb_is_special_numpy_computes(robot):
    q = np.repeat(robot.assemble().model_q, 3, axis=1)
    q[1, 1] += np.pi / 2
    frames, given = robot.mechanism.forward(q), (np.ones((6, 3)), np.ones((3, 3)))
    rng = np.random.default_rng(1)
    applied = (AppliedLoad("load on carriage_1", {"carriage_1": rng.standard_normal((6, 3))}),)
    compiled = CompiledStatics(robot.statics, LoadedPlaces.of(applied))
    assert CompiledStatics.kept(robot.statics, places=LoadedPlaces.of(applied)) is not None
    _, truths = compiled._computed(frames, *given, applied)
    assert truths[0].tolist() == [True, False, True]
    wanted = solve_with_springs(robot.statics, frames, *given, applied=applied)
    found = compiled.solve(frames, *given, applied)
    worst = differences(found, wanted)
    assert max(worst.values()) < 1e-11, max(worst, key=worst.get)
    assert found.sources == wanted.sources and found.whole.applied[0].load is applied[0]
    assert len(example_of(robot.statics, LoadedPlaces.of(applied))) == 4
