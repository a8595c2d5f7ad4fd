"""Loads on links and payloads in compiled code: loads are inputs, loaded places belong to the structure."""

from functools import partial

import numpy as np
import package_robots
import pytest
import tapes
from tapes import assert_same_results, computed
from turned_limbs import with_first_limb_turned

import kinetostatics as ks
from kinetostatics.engine import programs
from kinetostatics.engine.pose_code import ANALYSIS, PoseCode, pose_model
from kinetostatics.statics.loaded_poses import LoadedAttachments

close = partial(tapes.close, tolerance=1e-10)


@pytest.fixture(scope="module")
def robot():
    return package_robots.robot("linear_delta")


@pytest.mark.parametrize("poses", [1, 700])
def test_engines_agree_on_link_loads_and_payload(robot, poses):
    """A payload whose mass differs from pose to pose, and two loads on links; poses in reach and out of it."""
    x = np.linspace(-0.6, 0.6, poses) if poses > 1 else np.array([0.05])
    at = robot.assemble(platform={"x": x, "y": 0.1, "z": float(robot.assemble().platform["z"])}, on_failure="nan")
    loads = {
        "carriage_1": [10, -20, -30, 1, 2, 3],
        "platform": ks.LinkLoad([0, 5, -70, 0, 0, 0], point=(0.1, 0, 0), frame="link"),
    }
    given = {"payload": ks.Payload(np.linspace(1.0, 4.0, poses), (0.02, 0.01, -0.05)), "loads": loads, "load": [1, 2, 3, 0, 0, 0]}
    found, wanted = (ks.analyze(at, **given, engine=engine) for engine in ("compiled", "numpy"))
    assert_same_results(found, wanted)
    assert list(found.contributions)[-3:] == ["load on carriage_1", "load on platform", "payload"]
    assert (wanted.status < 2).sum() > min(poses - 1, 3) and (poses == 1 or 2 in wanted.status)
    close(found.payload_coefficients.twist, wanted.payload_coefficients.twist)
    places = [key for (key, _), item in programs._POSES[robot].items() if item.made is not None and key is not None]
    assert len(places) == 1 and [name for name, _ in places[0].loads] == ["load on carriage_1", "load on platform", "payload"]


def test_structure_key_depends_on_loaded_places(robot):
    keys = {
        pose_model(robot, robot.statics, ANALYSIS, places)[0].structure().key
        for places in (
            None,
            LoadedAttachments((("payload", ("platform",)),)),
            LoadedAttachments((("load on carriage_1", ("carriage_1",)),)),
            LoadedAttachments((("load on carriage_1", ("carriage_1",)), ("payload", ("platform",)))),
        )
    }
    assert len(keys) == 4
    assert LoadedAttachments.of(()) is None


def test_degenerate_loaded_limb_falls_back_to_numpy(robot):
    q = np.repeat(robot.assemble().model_q, 3, axis=1)
    q[:, 1] = with_first_limb_turned(robot, q[:, 1])
    poses, wrench = robot.configuration(q.T, closure_tolerance=np.inf), np.random.default_rng(1).standard_normal((3, 6))
    code = PoseCode(robot, robot.statics, ANALYSIS, LoadedAttachments((("load on carriage_1", ("carriage_1",)),)))
    _, holds = computed(code, poses.poses.x, np.ones((6, 3)), np.ones((3, 3)), wrench.T)
    assert holds.tolist() == [True, False, True]
    found, wanted = (ks.analyze(poses, loads={"carriage_1": wrench}, engine=engine) for engine in ("compiled", "numpy"))
    assert_same_results(found, wanted)
