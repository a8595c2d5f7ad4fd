"""Assembly modes along a grid: of the five-bar by closed form, and of grids with poses in wrong modes."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.files.bundled import robot_path
from kinetostatics.workspace import continuity
from kinetostatics.workspace.dataset import NOT_REACHED, REACHED, labels_of
from kinetostatics.workspace.sweep_arguments import read_plan


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def bends(robot, q):
    """Return on which side each elbow of a five-bar is bent, and the wrist: twice the areas of triangles [m²]."""
    pose = robot.configuration(q, closure_tolerance=np.inf, on_failure="nan")
    points = (pose.frame(link)[..., :2, 3] for link in ("proximal_1", "distal_1", "proximal_2", "distal_2", "tool"))
    A1, B1, A2, B2, C = points
    return cross(B1 - A1, C - B1), cross(B2 - A2, C - B2), cross(C - B1, C - B2)


def five_bar(**parameters):
    return ks.load_robot(robot_path("five_bar"), parameters)


@pytest.mark.slow
def test_five_bar_keeps_its_elbows_over_its_whole_workspace():
    """Gosselin's workspace: both arms reach a disc; with the elbows as at zero each point of both discs is one pose."""
    robot = five_bar()
    x, y = np.linspace(-0.6, 0.6, 61), np.linspace(-0.3, 0.6, 46)
    ds = ks.sweep(robot, {"x": x, "y": y})
    assert ds.attrs["mode_jumps"] == 0
    X, Y = np.meshgrid(x, y, indexing="ij")
    within = np.maximum(np.hypot(X + 0.1375, Y), np.hypot(X - 0.1375, Y)) < 0.46
    reached = ds["mode"].values == REACHED
    np.testing.assert_array_equal(reached, within)
    np.testing.assert_array_equal(ds["status"].values == ks.Status.UNREACHABLE, ~within)
    zero, found = bends(robot, robot.assemble().q), bends(robot, ds["q"].values[reached])
    for k in (0, 1):
        assert np.all(np.sign(found[k]) == np.sign(zero[k])), f"{np.sum(np.sign(found[k]) != np.sign(zero[k]))} elbows of arm {k}"
    # and values are those of these poses
    near = robot.configuration(ds["q"].values[30, 35])
    result = ks.analyze(near)
    np.testing.assert_allclose(ds["twist"].values[30, 35], result.twist, rtol=1e-9, atol=1e-18)


def test_five_bar_over_actuators_keeps_its_wrist():
    robot = five_bar()
    angles = np.linspace(-3, 3, 25)
    ds = ks.sweep(robot, actuators={"shoulder_1": angles, "shoulder_2": angles})
    assert ds.attrs["mode_jumps"] == 0
    reached = ds["mode"].values == REACHED
    assert reached.sum() > 370
    wrist = bends(robot, ds["q"].values[reached])[2]
    assert np.all(np.sign(wrist) == np.sign(bends(robot, robot.assemble().q)[2]))


@pytest.mark.slow
def test_poses_of_other_assembly_modes_are_unreachable():
    """Arms too unequal to reach the line between the motors: no path leads from above it to below."""
    robot = five_bar(proximal_length=0.28, distal_length=0.12)
    x, y = np.linspace(-0.3, 0.3, 31), np.linspace(-0.4, 0.4, 41)
    ds = ks.sweep(robot, {"x": x, "y": y})
    X, Y = np.meshgrid(x, y, indexing="ij")
    radii = np.array([np.hypot(X + 0.1375, Y), np.hypot(X - 0.1375, Y)])
    # an arm may stretch and fold, but not on a circle itself
    within = np.all((radii > 0.16 + 1e-9) & (radii < 0.40 - 1e-9), axis=0)
    mode = ds["mode"].values
    np.testing.assert_array_equal(mode == REACHED, within & (Y > 0))
    assert np.all(ds["status"].values[mode != REACHED] == ks.Status.UNREACHABLE)
    assert np.all(np.isnan(ds["twist"].values[mode != REACHED]))


# ---- grids with wrong or missing poses ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def valid_map():
    """Return a five-bar's plan, labels and map in the middle of its workspace, all in one mode."""
    robot = five_bar()
    grid = {"x": np.linspace(-0.1, 0.1, 15), "y": np.linspace(0.2, 0.35, 12)}
    ds = ks.sweep(robot, grid)
    assert np.all(ds["mode"] == REACHED)
    plan, _ = read_plan(robot, {"platform": grid})
    return robot, plan, labels_of(plan, robot), ds


def checked(valid_map, q, reached):
    robot, plan, labels, _ = valid_map
    region = tuple(slice(0, axis.size) for axis in plan.axes)
    o = np.zeros((*reached.shape, 3))  # not used where no rod is loose
    return continuity.continued(plan, labels, robot, region, q, o, reached)


def other_elbow(robot, ds, which):
    """Return the same poses with the first elbow bent the other way, by reflecting it in the line from motor to tool."""
    q = ds["q"].values[which].copy()
    values = {name: ds["platform_pose"].sel(platform_coordinate=name).values[which] for name in ("x", "y")}
    names = list(ds["joint_coordinate"].values)
    start = q.copy()
    a = bends(robot, q)[0]
    pose = robot.configuration(q)
    A, C = pose.frame("proximal_1")[..., :2, 3], pose.frame("tool")[..., :2, 3]
    B = pose.frame("distal_1")[..., :2, 3]
    to_tool, to_elbow = C - A, B - A
    turn = np.arctan2(cross(to_elbow, to_tool), np.sum(to_elbow * to_tool, axis=-1))  # from crank to line
    start[:, names.index("shoulder_1")] += 2 * turn
    bend = np.arctan2(cross(B - A, C - B), np.sum((B - A) * (C - B), axis=-1))
    start[:, names.index("elbow_1")] -= 2 * bend
    near = robot.configuration(start, closure_tolerance=np.inf, on_failure="nan")
    found = robot.assemble(platform=values, near=near)
    assert np.all(np.sign(bends(robot, found.q)[0]) == -np.sign(a))
    return found.q


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["one", "corner", "half", "checkered"])
def test_poses_in_a_wrong_mode_are_found_and_corrected(valid_map, kind):
    robot, _, _, ds = valid_map
    which = np.zeros(ds["mode"].shape, dtype=bool)
    if kind == "one":
        which[7, 6] = True
    elif kind == "corner":
        which[:6, :5] = True
    elif kind == "half":
        which[:, :7] = True  # the part that lies farther from the zero pose
    else:
        which[3:9:2, 3:9:2] = which[4:9:2, 4:9:2] = True
    q = ds["q"].values.copy()
    q[which] = other_elbow(robot, ds, which)
    found = checked(valid_map, q, np.ones(which.shape, dtype=bool))
    assert found.jumps == 0 and found.retracted >= which.sum()
    np.testing.assert_allclose(found.q, ds["q"].values.reshape(-1, q.shape[-1])[found.which], atol=1e-9)
    assert set(np.flatnonzero(which)) <= set(found.which)


def test_poses_unreached_along_a_line_are_reached_from_neighbours(valid_map):
    _, _, _, ds = valid_map
    reached = np.ones(ds["mode"].shape, dtype=bool)
    reached[5:, 4:11] = False
    q = np.where(reached[..., None], ds["q"].values, np.nan)
    found = checked(valid_map, q, reached)
    assert found.gained == np.sum(~reached)
    np.testing.assert_array_equal(found.which, np.flatnonzero(~reached))
    np.testing.assert_allclose(found.q, ds["q"].values[~reached], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("side", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_pose_between_reached_neighbours_is_tried_from_each(valid_map, monkeypatch, side):
    """It can be reached from one neighbour only; failures from the others do not settle it."""
    _, _, _, ds = valid_map
    reached = np.ones(ds["mode"].shape, dtype=bool)
    reached[6, 5] = False
    q = np.where(reached[..., None], ds["q"].values, np.nan)
    only = q[6 + side[0], 5 + side[1]]
    place = {name: ds[name].values[k] for name, k in (("x", 6), ("y", 5))}
    original = continuity._RegionPoses.follow

    def follow(self, starts, first, targets, steps=1):
        ends, arrived = original(self, starts, first, targets, steps)
        here = np.all([targets[name] == value for name, value in place.items()], axis=0)
        from_there = np.all(np.abs(starts[:, : len(only)] - only) < 1e-12, axis=1)
        return ends, arrived & (~here | from_there)

    monkeypatch.setattr(continuity._RegionPoses, "follow", follow)
    found = checked(valid_map, q, reached)
    assert found.gained == 1
    np.testing.assert_allclose(found.q[0], ds["q"].values[6, 5], atol=1e-9)


@pytest.mark.slow
def test_spinning_rods_do_not_separate_assembly_modes():
    """The Delta's rods spin as their paths leave them; its workspace is where Clavel's inverse kinematics has solutions.

    At a height of −0.5 m each arm folds back upon its rods in one point of the map, where the elbow's two ways meet: so near to
    it that they differ by less than 0.15 rad a grid of 50 mm does not separate them.
    """
    robot, z = package_robots.robot("delta"), -0.5
    x, y = np.linspace(-1.1, 1.1, 23), np.linspace(-1.1, 1.1, 22)
    ds = ks.sweep(robot, {"x": x, "y": y, "z": z})
    assert ds.attrs["mode_jumps"] == 0
    X, Y = np.meshgrid(x, y, indexing="ij")
    angles, apart = [], np.inf
    for azimuth in np.radians([0, 120, 240]):
        u, along, w = np.cos(azimuth) * X + np.sin(azimuth) * Y - 0.1, np.cos(azimuth) * Y - np.sin(azimuth) * X, z
        cosine = (u**2 + along**2 + w**2 + 0.3**2 - 0.8**2) / (2 * 0.3 * np.hypot(u, w))
        with np.errstate(invalid="ignore"):
            angles.append(np.arctan2(-w, u) - np.arccos(cosine))
            apart = np.minimum(apart, np.pi - np.abs(2 * np.arccos(cosine) - np.pi))
    expected = np.stack(angles, axis=-1)
    reached = ds["mode"].values == REACHED
    told = ~(apart < 0.15)
    assert np.sum(~told) < 8
    np.testing.assert_array_equal(reached[told], np.all(np.isfinite(expected), axis=-1)[told])
    assert 0.3 < np.mean(reached) < 0.5
    motors = [list(ds["joint_coordinate"].values).index(f"motor_{i}") for i in (1, 2, 3)]
    np.testing.assert_allclose(ds["q"].values[reached & told][:, motors], expected[reached & told], atol=1e-9)


def test_only_spins_of_delta_rods_are_loose_coordinates():
    loose = {}
    for name in ("delta", "five_bar", "gough_stewart"):
        robot = package_robots.robot(name)
        plan, _ = read_plan(robot, {"actuators": dict.fromkeys(robot.description.actuated, 0.0)})
        labels = labels_of(plan, robot)
        loose[name] = {label for label, one in zip(labels.axes["joint_coordinate"], labels.undetermined, strict=True) if one}
    assert loose["five_bar"] == loose["gough_stewart"] == set()
    kept = {f"{part}_{i}" for part in ("motor", "elbow") for i in (1, 2, 3)}
    spins = {
        f"{end}_{i}{side}_z:{part}" for end in ("upper", "lower") for i in (1, 2, 3) for side in "ab" for part in ("cos", "sin")
    }
    assert not loose["delta"] & kept
    assert loose["delta"] & spins == spins & set(ks.sweep("delta", {"x": [0.0], "y": 0.0, "z": -0.6})["joint_coordinate"].values)


def test_grid_out_of_reach_is_entirely_unreachable():
    ds = ks.sweep("five_bar", {"x": np.linspace(2, 3, 5), "y": np.linspace(0, 1, 4)})
    assert np.all(ds["mode"] == NOT_REACHED) and np.all(ds["status"] == ks.Status.UNREACHABLE) and np.all(np.isnan(ds["twist"]))


@pytest.mark.slow
def test_large_map_checked_in_pieces_stays_in_one_mode(monkeypatch):
    """A piece has fewer neighbours: poses beside singular ones may be given up; none is in the wrong mode."""
    robot = five_bar()
    x, y = np.linspace(-0.6, 0.6, 41), np.linspace(-0.3, 0.6, 31)
    monkeypatch.setattr("kinetostatics.workspace.block.REGION", 7 * len(y) * 4)
    ds = ks.sweep(robot, {"x": x, "y": y})
    assert ds.attrs["mode_jumps"] == 0
    X, Y = np.meshgrid(x, y, indexing="ij")
    reached = ds["mode"].values == REACHED
    within = np.maximum(np.hypot(X + 0.1375, Y), np.hypot(X - 0.1375, Y)) < 0.46
    assert not np.any(reached & ~within) and np.sum(within & ~reached) <= 4
    zero, found = bends(robot, robot.assemble().q), bends(robot, ds["q"].values[reached])
    for k in (0, 1):
        assert np.all(np.sign(found[k]) == np.sign(zero[k]))
