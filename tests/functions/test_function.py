"""Functions of a robot against the analysis; their derivatives against central differences with loops closed anew."""

from types import SimpleNamespace

import numpy as np
import package_robots
import parametric_machines
import pytest
from loop_robots import actuated, joint, loop, robot
from places import CASES
from scipy.spatial.transform import Rotation
from simple_machines import springs

import kinetostatics as ks
from kinetostatics.description import JointStiffness
from kinetostatics.functions import function
from kinetostatics.functions.derivatives import Derivatives
from kinetostatics.parametric.robot_numbers import numbers_of_parts

LOAD = np.array([30.0, -40.0, -500.0, 3.0, 4.0, 5.0])
GRAVITY = np.array([0.5, -1.0, -9.7])
OUTPUTS = ("twist", "actuator_forces", "stiffness", "actuators")
#: Coordinates of the platform, or those of all actuators, of a serial robot, of parallel ones and of one with rings.
POSES = {
    "3rps": {"z": 0.52, "rx": 0.1, "ry": -0.15},
    "2pru_upr": {"z": 0.6, "rx": 0.05, "ry": -0.1},
    "gough_stewart": {"x": 0.03, "y": -0.02, "z": 0.58, "rx": 0.05, "ry": 0.1, "rz": -0.07},
    "delta": {"x": 0.05, "y": -0.03, "z": -0.62},
    "five_bar": None,
    "ur10": None,
    "tripteron": {"x": 0.02, "y": -0.03, "z": 0.01},
}
_FUNCTIONS = {}


def function_of(name):
    """Return a function of a robot of the package, and a pose."""
    if name not in _FUNCTIONS:
        robot = package_robots.robot(name)
        at = POSES[name] or dict.fromkeys(robot.description.actuated, 0.0)
        if POSES[name] is None:
            at = {drive: 0.1 + 0.07 * k for k, drive in enumerate(at)}
        _FUNCTIONS[name] = ks.compile(robot, POSES[name], outputs=OUTPUTS), at
    return _FUNCTIONS[name]


def differences(f, at, by):
    """Return the outputs' derivatives by an input: central differences of fourth order, all in one call."""
    start = {"load": LOAD, "gravity": GRAVITY, **{key: np.array(value) for key, value in at.items()}}
    size, h = start[by].size, 2e-4
    steps = np.array([-2, -1, 1, 2]) * h
    moved = start[by] + np.einsum("s,kj->skj", steps, np.eye(size)).reshape(4, size, *start[by].shape)
    found = f(**{**start, by: moved})
    assert np.all(found["status"] <= ks.Status.LIMIT_EXCEEDED)
    weights = np.array([1, -8, 8, -1]) / (12 * h)
    result = {name: np.moveaxis(np.einsum("s,sk...->k...", weights, found[name]), 0, -1) for name in OUTPUTS}
    return {name: array.reshape(*array.shape[:-1], *start[by].shape) for name, array in result.items()}


def assert_alike(found, wanted, size, tolerance):
    """Compare derivatives relative to the largest of them, with an allowance for rounding of the differenced function."""
    rounding = 1e-10 * np.max(np.abs(size))
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * np.max(np.abs(wanted)) + rounding)


def test_function_defaults_equal_the_analysis_defaults():
    f, at = function_of("2pru_upr")
    found, result = f(**at), ks.analyze(package_robots.robot("2pru_upr").assemble(platform=at))
    np.testing.assert_allclose(found["twist"], result.twist, rtol=1e-11)
    np.testing.assert_allclose(found["stiffness"], result.stiffness, rtol=1e-9, atol=1e-9 * np.max(result.stiffness))
    assert all(np.shape(found[name]) == f.outputs[name].shape for name in OUTPUTS)
    jacobian = f.jacobian("twist", "z")
    slope = jacobian(**at, load=np.zeros(6), gravity=(0, 0, -9.81))["twist"]["z"]
    np.testing.assert_array_equal(jacobian(**at)["twist"]["z"], slope)


def test_function_angles_follow_the_orientation_convention():
    robot, at = package_robots.robot("2pru_upr"), {"z": 0.6, "rx": 0.2, "ry": -0.25}
    found = {name: ks.compile(robot, at, orientation=name, outputs="twist")(**at)["twist"] for name in ("XYZ", "xyz")}
    for name, twist in found.items():
        wanted = ks.analyze(robot.assemble(platform=at, orientation=name)).twist
        np.testing.assert_allclose(twist, wanted, rtol=1e-10, atol=1e-10 * np.max(np.abs(wanted)))
    assert np.max(np.abs(found["XYZ"] / found["xyz"] - 1)) > 0.01


@pytest.mark.few(2)
@pytest.mark.parametrize("name", POSES)
def test_jacobian_by_inputs_equals_central_differences(name):
    f, at = function_of(name)
    by = (*at, "load", "gravity")
    J = f.jacobian(OUTPUTS, by)(load=LOAD, gravity=GRAVITY, **at)
    values = f(load=LOAD, gravity=GRAVITY, **at)
    for key in by:
        wanted = differences(f, at, key)
        for output in OUTPUTS:
            assert J[output][key].shape == f.outputs[output].shape + f.inputs[key].shape
            assert_alike(J[output][key], wanted[output], values[output], 1e-7)


def by_other_robots(f, at, name, k):
    """Return the derivatives by a parameter from robots made anew with it a little smaller and larger, and the step."""
    number = numbers_of_parts(f.robot)[name][k]
    h = number.step / 10
    by_drives = set(at) == set(f.robot.description.actuated)
    found = []
    for sign in (-1, 1):
        g = ks.compile(ks.Robot(number.changed(sign * h)), None if by_drives else tuple(at), outputs=OUTPUTS)
        found.append(g(load=LOAD, gravity=GRAVITY, **at))
    return {output: (found[1][output] - found[0][output]) / (2 * h) for output in OUTPUTS}, h


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("name", "parameter", "k"),
    [
        ("3rps", "revolute_2.placement", 0),
        ("five_bar", "tool.mass", 0),
        ("2pru_upr", "rod_2.outer_diameter", 0),
        pytest.param("ur10", "elbow_joint.placement", 1, marks=pytest.mark.slow),
        ("tripteron", "rail_1.actuator_stiffness", 0),
    ],
)
def test_jacobian_by_parameters_equals_changed_robots(name, parameter, k):
    f, at = function_of(name)
    J = f.jacobian(OUTPUTS, parameter)(load=LOAD, gravity=GRAVITY, **at)
    wanted, h = by_other_robots(f, at, parameter, k)
    values = f(load=LOAD, gravity=GRAVITY, **at)
    for output in OUTPUTS:
        found = J[output][parameter]
        found = found[..., k] if f.parameters[parameter].shape else found
        assert_alike(found, wanted[output], values[output] * (2e-4 / h), 1e-6)
    assert np.max(np.abs(J["twist"][parameter])) > 0


@pytest.mark.slow
@pytest.mark.few(1)
@pytest.mark.parametrize("k", range(3))
def test_jacobian_by_shift_of_a_universal_joint_axis(k):
    """The shifted axes do not meet, or meet elsewhere: the joint becomes two hinges or moves, and the loops still close."""
    name = "universal_3_y.placement"
    f, at = function_of("2pru_upr")
    J, values = f.jacobian(OUTPUTS, name)(load=LOAD, gravity=GRAVITY, **at), f(load=LOAD, gravity=GRAVITY, **at)
    wanted, h = by_other_robots(f, at, name, k)
    for output in OUTPUTS:
        assert_alike(J[output][name][..., k], wanted[output], values[output] * (2e-4 / h), 1e-6)
    assert np.max(np.abs(J["twist"][name][..., k])) > 1e-6


@pytest.mark.few(1)
@pytest.mark.parametrize(("links", "sign"), [(("base", "platform"), 1), (("platform", "base"), -1)])
def test_jacobian_of_a_actuated_loop_joint_by_its_placements(links, sign):
    """A platform on a soft slide, with an actuated slide beside it, whose coordinate changes with shifts of its own frames."""
    still, up = np.eye(4), (0, 0, 1)
    soft = springs("guide", linear="1e6 1e6 1e6", angular="1e5 1e5 1e5")
    parts = [joint("guide", "prismatic", "base", "platform", still, up), soft, actuated("drive")]
    slide = robot(*parts, loop("prismatic", links[0], still, links[1], still, axis=up, name="drive"))
    f = ks.compile(slide, ("z",), outputs=("actuators",))
    places = ("drive.predecessor_placement", "drive.successor_placement")
    J = f.jacobian("actuators", ("z", "load", *places))(z=1e-4)["actuators"]
    assert J["z"] == pytest.approx(sign) and not J["load"].any()
    assert [float(J[place][0, 2]) for place in places] == pytest.approx([-1.0, 1.0])


def test_jacobian_with_elastic_hinge_inside_a_spherical_joint():
    """The bodies between its hinges, which the solver passes over, have frames of their own."""
    soft = JointStiffness("spherical_1_y", linear=(1e6, 2e6, 1.5e6))
    machine = ks.Robot(package_robots.robot("gough_stewart").description.with_part(soft))
    at = {"x": 0.02, "y": -0.01, "z": float(machine.assemble().platform["z"]) + 0.01, "rx": 0.1, "ry": -0.15, "rz": 0.05}
    assert "spherical_1_y" in machine.mechanism.spherical_runs[0].joints
    f = ks.compile(machine, tuple(at), outputs=OUTPUTS)
    J, values = f.jacobian("twist", tuple(at))(load=LOAD, gravity=GRAVITY, **at), f(load=LOAD, gravity=GRAVITY, **at)
    for key in ("z", "rx", "ry"):
        assert_alike(J["twist"][key], differences(f, at, key)["twist"], values["twist"], 1e-7)


@pytest.mark.parametrize(("size", "gain"), [(1.0, 1.0), (4e-9, 2.5e8), (3e-10, 0.0)])
def test_loop_gradient_rank_tolerance_is_1e_9(size, gain):
    """Singular values of the loops' gradient on both sides of a part in 10⁹ of the largest."""
    solver = SimpleNamespace(rates=lambda *_: (np.diag([1.0, size])[:, :, None], np.zeros((2, 1, 1))))
    found = object.__new__(Derivatives)
    found.robot, found.prescribed, found.target = SimpleNamespace(solver=solver), None, None
    found.pose = SimpleNamespace(poses=None)
    np.testing.assert_allclose(found._closing[1][0], np.diag([1.0, gain]), rtol=1e-12)


@pytest.mark.parametrize("compensate", [False, True])
def test_outputs_have_declared_shapes_units_and_components(compensate):
    outputs = ("twist", "contributions", "stiffness", "compliance", "actuator_forces", "actuators")
    f = ks.compile(
        package_robots.robot("five_bar"), ("x", "y"), outputs=(*outputs, *["residual_error"] * compensate), compensate=compensate
    )
    values = f(x=[0.0, 0.01, 0.02], y=0.3, load=[3.0, -4.0, 0, 0, 0, 0], gravity=(0, 0, -9.81))
    for item in (*f.outputs.values(), *f.inputs.values()):
        assert len(item.units) in (1, *item.shape) and [*map(len, item.axes.values())] in ([], [*item.shape])
        if item.name in values:
            assert values[item.name].shape == (3, *item.shape)
    assert ("UNREACHABLE also where no correction was found" in str(f)) is compensate
    assert "gravity (3,) [m/s²]: gravity, world axes" in str(f) and "x [m]: coordinate of o, world axes" in str(f)


def test_jacobian_of_batches_equals_single_poses():
    """Poses, loads and gravity along separate axes; more poses than are differentiated at once."""
    f = ks.compile(package_robots.robot("five_bar"), outputs=(*OUTPUTS, "compliance"))
    J = f.jacobian((*OUTPUTS, "compliance"), ("shoulder_1", "load", "gravity"))
    turn = np.linspace(-0.1, 0.1, 6)
    loads, fields = np.array([LOAD, 2 * LOAD, -LOAD])[:, None, None], np.array([GRAVITY, -GRAVITY, 0 * GRAVITY])[:, None]
    found = J(shoulder_1=turn, shoulder_2=0.2, load=loads, gravity=fields)
    for a, b, c in ((0, 0, 0), (1, 2, 3), (2, 1, 5)):
        one = J(shoulder_1=turn[c], shoulder_2=0.2, load=loads[a, 0, 0], gravity=fields[b, 0])
        for output, parts in found.items():
            for name, array in parts.items():
                assert array.shape[:3] == (3, 3, 6)
                size = np.max(np.abs(one[output][name]))
                np.testing.assert_allclose(array[a, b, c], one[output][name], rtol=1e-9, atol=1e-9 * size)


def test_jacobian_is_nan_where_no_pose_is_reached():
    f, at = function_of("delta")
    parameters = ("platform.mass", next(name for name in f.parameters if name.endswith("diameter")))
    found = f.jacobian(OUTPUTS, ("z", "load", *parameters))(**{**at, "z": [-9.0]}, load=LOAD)
    for output, parts in found.items():
        for name, array in parts.items():
            shape = (f.inputs[name] if name in f.inputs else f.parameters[name]).shape
            assert array.shape == (1, *f.outputs[output].shape, *shape) and np.isnan(array).all()


def test_jacobian_by_infinite_stiffness_is_zero():
    """A joint that is rigid across its axis: its stiffness there is infinite."""
    stiff = JointStiffness("prismatic_1", linear=(1e8, np.inf, 1e9))
    f = ks.compile(ks.Robot(package_robots.robot("3rps").description.with_part(stiff)), ("z", "rx", "ry"), outputs=OUTPUTS)
    found = f.jacobian(OUTPUTS, "prismatic_1.linear_stiffness")(z=0.52, rx=0.1, ry=-0.15, load=LOAD)
    for output, parts in found.items():
        array = parts["prismatic_1.linear_stiffness"]
        assert np.all(array[..., 1] == 0) and (np.any(array[..., ::2] != 0) or output == "actuators")


@pytest.mark.parametrize("k", range(6))
def test_placement_changes_are_in_the_joints_own_axes(k):
    """The changed frame of the joint against SciPy's rotation."""
    number = numbers_of_parts(package_robots.robot("2pru_upr"))["universal_3_y.placement"][k]
    before = number.description.joints["universal_3_y"].origin.matrix
    after = number.changed(0.01).joints["universal_3_y"].origin.matrix
    step = 0.01 * np.eye(6)[k]
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = Rotation.from_rotvec(step[3:]).as_matrix(), step[:3]
    np.testing.assert_allclose(after, before @ moved, atol=1e-12)


@pytest.mark.parametrize("engine", ["numpy", pytest.param("compiled", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("off", "status"), [(3e-11, ks.Status.OK), (1e-9, ks.Status.UNREACHABLE)])
def test_loops_may_stay_open_within_the_tolerance(off, status, engine):
    """An axis of one limb of an overconstrained robot is turned; its loops stay open by about half the angle."""
    turned = numbers_of_parts(package_robots.robot("2pru_upr"))["universal_3_y.placement"][5].changed(off)
    at = {"z": 0.55, "rx": 0.1, "ry": 0.05}
    assert ks.compile(ks.Robot(turned), tuple(at), engine=engine)(**at)["status"] == status


def test_jacobian_uses_the_engine_of_the_function(monkeypatch):
    engines = []
    monkeypatch.setattr(function, "analyze", lambda *args, **how: engines.append(how["engine"]) or ks.analyze(*args, **how))
    for engine in ("numpy", "compiled"):
        f = ks.compile(package_robots.robot("five_bar"), engine=engine)
        f.jacobian("twist", "load")(shoulder_1=0.1, shoulder_2=0.2)
    assert engines == ["numpy", "compiled"]


def test_jacobian_is_nan_where_overconstrained_loops_cannot_close():
    f, at = function_of("2pru_upr")
    rates = f.jacobian("twist", "revolute_1.placement")(**at)["twist"]["revolute_1.placement"]
    assert np.any(np.isnan(rates))


def test_overconstrained_rigid_limbs_have_no_jacobian():
    robot = ks.load_robot(CASES / "two_rigid.urdf")
    f = ks.compile(robot)
    at = dict.fromkeys(robot.description.actuated, 0.0)
    assert f(**at)["status"] in (ks.Status.OK, ks.Status.INDETERMINATE)
    with pytest.raises(ks.ArgumentError, match="has no derivatives: rigid limbs or rings overconstrain one another"):
        f.jacobian("twist", "load")(**at)


def test_robot_without_actuators_is_a_function_of_load(tmp_path):
    """A cantilever's tip goes down by F L³ / (3 E I)."""
    f = ks.compile(ks.load_robot(parametric_machines.cantilever(tmp_path)), outputs=("twist", "actuator_forces", "actuators"))
    values = f(load=[0, 0, -500, 0, 0, 0], gravity=(0, 0, 0))
    I_y = np.pi * 0.04**4 / 64
    assert values["twist"][2] == pytest.approx(-500 * 0.8**3 / (3 * parametric_machines.E * I_y), rel=1e-9)
    assert values["actuator_forces"].shape == values["actuators"].shape == (0,)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda f, at: f(**{**at, "y": 0.1}), "this function has no input 'y'"),
        (lambda f, at: f(z=0.5), "the coordinates rx, ry are missing"),
        (lambda f, at: f.jacobian("status", "z"), r"no output 'status' with derivatives: (?!.*outputs=)"),
        (lambda f, at: f.jacobian("twist", "z")(**at, near=f.robot.assemble(platform={**at, "z": [0.5, 0.6]})), "a single pose"),
        (lambda f, at: f.jacobian("compliance", "z"), r"'compliance' with derivatives: .*must be named in outputs="),
        (lambda f, at: f.jacobian("twist", "rod_1.outer_diametre"), "has no parameter 'rod_1.outer_diametre'"),
        (lambda f, at: f.jacobian("twist", "z")(**{**at, "z": [0.5, 0.6]}, load=np.zeros((3, 6))), "do not fit together"),
        (lambda f, at: f(**at)["twists"], "there is no 'twists' here; did you mean 'twist'"),
        (lambda f, at: ks.compile(f.robot, tuple(at), outputs="sag"), "no output 'sag'"),
        (lambda f, at: ks.compile("3rps"), "compile needs a Robot"),
        (lambda f, at: ks.compile(f.robot, tuple(at), actuators=("prismatic_1",)), "either platform= or actuators="),
        (lambda f, at: ks.compile(f.robot, orientation="XYZ"), "orientation= applies to coordinates of the platform"),
        (lambda f, at: ks.compile(f.robot, ("z", "rx")), "give exactly 3 of"),
    ],
)
def test_invalid_arguments_of_functions_raise(call, words):
    with pytest.raises((ks.ArgumentError, ks.exceptions.UnknownNameError), match=words):
        call(*function_of("3rps"))
