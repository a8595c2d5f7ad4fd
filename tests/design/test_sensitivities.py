"""Derivatives by parameters of the file, against closed forms, laws of scale and differences of whole analyses."""

import json

import numpy as np
import odd_robots
import package_robots
import parametric_machines
import pytest

import kinetostatics as ks
from kinetostatics.design.sensitivities import _has_influence, numbers_of
from kinetostatics.files.reader import read_robot_file
from kinetostatics.functions import derivatives
from kinetostatics.parametric.parametric_robot import ParametricRobot
from kinetostatics.results.sensitivities import QUANTITIES, Sensitivity

LOAD = [0, 0, -300, 0, 20, 0]


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    path = parametric_machines.cantilever(tmp_path_factory.mktemp("files"))
    return ks.sensitivities(ks.load_robot(path).assemble(), load=[10, 0, -300, 0, 0, 0])


def test_cantilever_derivatives_have_closed_form(cantilever):
    """w = F L³/3EI + q L⁴/8EI, with the tip's weight in F; m = ρAL + m_tip."""
    L, d, E, rho, m, g = 0.8, 0.04, 2e11, 7850, 5.0, 9.81
    A, inertia = np.pi * d**2 / 4, np.pi * d**4 / 64
    point, line = (300 + m * g) * L**3 / (3 * E * inertia), rho * A * g * L**4 / (8 * E * inertia)
    assert cantilever.result.twist[2] == pytest.approx(-(point + line), rel=1e-9)
    expected = {
        "diameter": (-4 * point - 2 * line) / d,
        "length": (3 * point + 4 * line) / L,
        "E": -(point + line) / E,
        "density": line / rho,
        "tip_mass": g * L**3 / (3 * E * inertia),
    }
    assert set(cantilever) == set(expected) and next(iter(cantilever)) == "diameter"
    for name, slope in expected.items():
        assert cantilever[name].twist[2] == pytest.approx(-slope, rel=1e-6), name
    assert cantilever["diameter"].mass == pytest.approx(2 * rho * A * L / d, rel=1e-6)
    assert cantilever["length"].twist[0] == pytest.approx(10 / (E * A), rel=1e-6)  # the pull of 10 N
    assert cantilever["E"].stiffness[0, 0] == pytest.approx(A / L, rel=1e-6)
    assert [cantilever[name].unit for name in ("diameter", "E", "tip_mass")] == ["m", "Pa", "kg"]


def test_zero_mass_has_a_one_sided_derivative(cantilever, tmp_path):
    """Negative masses are refused: the difference is one-sided. Effects are linear in the mass."""
    robot = ks.load_robot(parametric_machines.cantilever(tmp_path), {"tip_mass": 0})
    found = ks.sensitivities(robot.assemble(), ["tip_mass"], load=[10, 0, -300, 0, 0, 0])["tip_mass"]
    assert found.value == 0 and not found.exact and found.mass == pytest.approx(1, rel=1e-9)
    np.testing.assert_allclose(found.twist, cantilever["tip_mass"].twist, rtol=1e-6, atol=1e-6 * np.abs(found.twist).max())


def test_twist_parts_of_beams_are_derivatives_by_stiffness(cantilever):
    np.testing.assert_allclose(cantilever.sources["rod"], -cantilever["E"].twist * cantilever["E"].value, rtol=1e-6, atol=1e-16)
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05})
    s = ks.sensitivities(pose, ["youngs_modulus", "density"], load=LOAD)
    # all rods have one modulus, and all that weighs one density
    whole = s["youngs_modulus"]
    np.testing.assert_allclose(sum(s.sources.values()), -whole.twist * whole.value, rtol=1e-6, atol=1e-15)
    by_weight = s.result.twist - s.result.contributions["load"]
    np.testing.assert_allclose(s["density"].twist * s["density"].value, by_weight, rtol=1e-6, atol=1e-15)
    for drive, force in s["youngs_modulus"].actuator_forces.items():
        assert abs(float(force)) * whole.value < 1e-5 * abs(float(s.result.actuator_forces[drive]))  # statically determinate
    assert s["density"].mass * s["density"].value == pytest.approx(float(s.result.base_wrench[2] - 300) / 9.81, rel=1e-6)


def test_tool_tip_derivatives_of_the_cantilever_have_closed_form(tmp_path):
    """w = (F/EI) (L³/3 + a L²/2 + a (L²/2 + a L)) of a force at the end of a tool that is a longer than the rod."""
    L, d, E, F, a = 0.8, 0.04, 2e11, 300.0, 0.2
    inertia = np.pi * d**4 / 64
    pose = ks.load_robot(parametric_machines.cantilever(tmp_path)).assemble()
    load = {"load": [0, 0, -F, 0, a * F, 0], "gravity": (0, 0, 0)}  # at the tip, about o
    found = ks.sensitivities(pose, ["diameter", "length"], tool=(a, 0, 0), **load)
    w = F / (E * inertia) * (L**3 / 3 + a * L**2 + a**2 * L)
    by_length = F / (E * inertia) * (L + a) ** 2
    assert found.seen.twist[2] == pytest.approx(-w, rel=1e-9)
    assert found["diameter"].twist[2] == pytest.approx(4 * w / d, rel=1e-8)
    assert found["length"].twist[2] == pytest.approx(-by_length, rel=1e-8)
    assert found["length"].compliance[2, 2] == pytest.approx(by_length / F, rel=1e-8)
    stiffness = found.seen.stiffness @ found["length"].compliance @ found.seen.stiffness
    np.testing.assert_allclose(found["length"].stiffness, -stiffness, rtol=1e-6, atol=1e-6 * np.abs(stiffness).max())
    assert found.sources["rod"][2] == pytest.approx(-w, rel=1e-9)
    assert found.effect("diameter")[0] == pytest.approx(-0.04 * w, rel=1e-8)
    assert "the tool's tip moves by" in str(found) and "the tool's tip moves by" in repr(found)
    told = found.to_dict()
    assert told["tool"] == [a, 0, 0] and told["twist"][2] == pytest.approx(-w) and "at the tool's tip" in told["units"]["twist"]
    with pytest.raises(ks.ArgumentError, match=r"tool is \(0, 0.2\); it must be three numbers"):
        ks.sensitivities(pose, tool=(0, 0.2))


@pytest.mark.slow
def test_tool_tip_derivatives_include_platform_rotation():
    """With its actuators held the leaning tripod turns when its base grows, and the tool with it: against whole analyses."""
    pose = package_robots.robot("3rps").assemble(actuators={"prismatic_1": 0.05, "prismatic_2": -0.05, "prismatic_3": 0.0})
    options = {"load": LOAD, "tool": (0.3, 0.2, -0.1)}
    exact = ks.sensitivities(pose, ["base_radius"], **options)["base_radius"]
    found = ks.sensitivities(pose, ["base_radius"], assembly_errors={}, **options)["base_radius"]
    assert exact.exact and not found.exact
    for name in ("twist", "stiffness", "compliance"):
        one, other = getattr(exact, name), getattr(found, name)
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-6 * np.abs(other).max(), err_msg=name)


@pytest.mark.slow
def test_tool_tip_derivatives_with_rigid_limbs():
    """Infinite stiffness does not affect the derivatives of the twist."""
    robot = package_robots.robot("3rps")
    robot = ks.Robot(robot.description.without_beam("rod_2").without_beam("rod_3"))
    pose, tool = robot.assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.05}), (0.05, -0.04, 0.1)
    at_o, at_tip = (ks.sensitivities(pose, ["rod_1.outer_diameter"], load=LOAD, tool=place) for place in (None, tool))
    assert np.all(np.isnan(at_tip.result.stiffness)) and at_tip["rod_1.outer_diameter"].exact
    one = at_o["rod_1.outer_diameter"].twist
    wanted = one[:3] + np.cross(one[3:], pose.platform_frame[:3, :3] @ tool)
    np.testing.assert_allclose(at_tip["rod_1.outer_diameter"].twist, [*wanted, *one[3:]], rtol=1e-9)
    off = ks.tolerances(pose, {"rod_1.outer_diameter": "0.1mm"}, load=LOAD, tool=tool, samples=5).effects["rod_1.outer_diameter"]
    np.testing.assert_allclose(off.twist, 1e-4 * np.append(wanted, one[3:]), rtol=1e-9)


def test_part_derivatives_equal_those_of_file_arguments(cantilever):
    """The rod's own diameter, modulus and density against the file's arguments, its end's placement against the length."""
    own = {"diameter": "rod.outer_diameter", "E": "rod.youngs_modulus", "density": "rod.density", "tip_mass": "tip.mass"}
    own["length"] = "end.placement.x"
    found = ks.sensitivities(cantilever.result.configuration, list(own.values()), load=[10, 0, -300, 0, 0, 0])
    assert next(iter(found)) == "rod.outer_diameter" and list(found)[-1] == "end.placement.x"
    for argument, name in own.items():
        assert found[name].exact and found[name].unit == cantilever[argument].unit
        for what in ("twist", "stiffness", "compliance", "mass"):
            one, other = getattr(found[name], what), getattr(cantilever[argument], what)
            np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-8 * np.abs(other).max(), err_msg=f"{name} {what}")
    assert found.shift_effect("end.placement.x") == pytest.approx(
        1e-3 * np.hypot(*found["end.placement.x"].twist[[0, 2]]), rel=1e-2
    )


def test_file_without_arguments_has_part_parameters(cantilever, tmp_path):
    """Also a robot changed after loading; placements are included by name only."""
    path = tmp_path / "plain.urdf"
    ks.save_robot(cantilever.result.robot, path)
    found = ks.sensitivities(ks.load_robot(path).assemble(), load=[10, 0, -300, 0, 0, 0])
    assert set(found) == {"rod.outer_diameter", "rod.youngs_modulus", "rod.density", "tip.mass"}  # ν does nothing here
    np.testing.assert_allclose(found["rod.outer_diameter"].twist, cantilever["diameter"].twist, rtol=1e-8, atol=1e-16)
    assert "increasing each dimension of a part by 1 %" in str(found)
    changed = ks.Robot(cantilever.result.robot.description.changed("rod", density=1000.0))
    assert "rod.outer_diameter" in ks.sensitivities(changed.assemble())


def test_part_derivatives_equal_differences_of_analyses():
    """One rod's sizes and one joint's place and turn, against central differences of robots made anew, by halved steps."""
    robot = package_robots.robot("3rps")
    where = {"z": 0.5, "rx": 0.1, "ry": -0.05}
    names = ["rod_1.outer_diameter", "revolute_2.placement.rx"]
    s = ks.sensitivities(robot.assemble(platform=where), names, load=LOAD)
    parameters = ParametricRobot(robot).parts
    for name in names:
        slopes = []
        for step in (parameters[name].step / 2, parameters[name].step / 4):
            ends = [ks.Robot(parameters[name].changed(by)).assemble(platform=where) for by in (-step, step)]
            low, high = (ks.analyze(pose, LOAD) for pose in ends)
            drive = [pose.actuators["prismatic_2"] for pose in ends]
            numbers = [
                [*r.twist, *r.stiffness.ravel(), r.actuator_forces["prismatic_2"], d]
                for r, d in zip((low, high), drive, strict=True)
            ]
            slopes.append(np.subtract(*numbers[::-1]) / (2 * step))
        exact = (4 * slopes[1] - slopes[0]) / 3
        item = s[name]
        assert item.exact
        parts = [(item.twist, slice(6), 3), (item.stiffness.ravel(), slice(6, 42), 36)]
        for found, part, size in parts:
            np.testing.assert_allclose(found, exact[part], rtol=1e-6, atol=1e-6 * np.abs(exact[part][:size]).max(), err_msg=name)
        np.testing.assert_allclose(item.actuator_forces["prismatic_2"], exact[42], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(item.actuators["prismatic_2"], exact[43], rtol=1e-6, atol=1e-9)


def test_patterns_skip_parameters_that_open_loops():
    """Shifts of the two actuators' bases have opposite effects; heights within a planar loop cannot differ."""
    pose = package_robots.robot("five_bar").assemble()
    s = ks.sensitivities(pose, ["shoulder_?.placement.y", "*.predecessor_placement.z"], load=[1, 0, 0, 0, 0, 0])
    assert set(s) == {"shoulder_1.placement.y", "shoulder_2.placement.y"} and list(s.skipped) == ["wrist.predecessor_placement.z"]
    one, other = (s.shift_effect(f"shoulder_{k}.placement.y") for k in (1, 2))
    assert one == pytest.approx(-other, rel=1e-6) and abs(one) > 1e-7
    text = str(s)
    assert "moving each placement or centre of mass by 1 mm or 1 mrad" in text
    assert "wrist.predecessor_placement.z was left out: with a small change of it" in text
    with pytest.raises(ks.ArgumentError, match=r"^wrist.predecessor_placement.z: with a small change of it the loops"):
        ks.sensitivities(pose, ["wrist.predecessor_placement.z"])


@pytest.mark.slow
def test_mass_derivative_includes_rods_of_variable_length():
    """The base's radius moves the actuators of the 2PRU-UPR, and one of its rods grows: against poses assembled anew."""
    at = {"z": 0.6, "rx": -0.1, "ry": 0.2}
    pose = package_robots.robot("2pru_upr").assemble(platform=at)
    found = ks.sensitivities(pose, ["base_radius"])["base_radius"]
    masses = []
    for radius in (0.5 - 1e-4, 0.5 + 1e-4):
        robot = package_robots.robot("2pru_upr", base_radius=radius)
        masses.append(ks.analyze(robot.assemble(platform=at)).base_wrench[2] / 9.81)
    assert found.exact and found.mass > 1
    assert found.mass == pytest.approx((masses[1] - masses[0]) / 2e-4, rel=1e-6)


def test_file_is_read_at_most_four_times_per_parameter(tmp_path, monkeypatch):
    """Derivatives, mass and unit share these readings; two suffice for a parameter without effect on statics."""
    reads = []

    def counted(path, parameters, **links):
        reads.append(dict(parameters))
        return read_robot_file(path, parameters, **links)

    path = parametric_machines.cantilever(tmp_path)
    lamp = '<visual><geometry><sphere radius="$(arg holes)"/></geometry></visual>'
    path.write_text(
        path.read_text(encoding="utf-8").replace('<link name="base"/>', f'<link name="base">{lamp}</link>'), encoding="utf-8"
    )
    pose = ks.load_robot(path).assemble()
    monkeypatch.setattr("kinetostatics.parametric.parametric_robot.read_robot_file", counted)
    found = ks.sensitivities(pose, ["diameter", "holes"])
    assert len(reads) == 1 + 4 + 2 + 1  # the robot's own; the diameter; the parameter of a drawn shape, and its unit
    assert not np.any(found["holes"].twist) and found["holes"].mass == 0 and found["holes"].exact
    assert len({tuple(item.items()) for item in reads}) == len(reads)


@pytest.mark.few(1)
@pytest.mark.parametrize("exactly", [True, False])
def test_only_requested_outputs_are_differentiated(cantilever, monkeypatch, exactly):
    """Values equal those among all outputs; the others are neither recorded nor in tables, and refused by name."""
    recorded, plain = [], derivatives.Derivatives
    monkeypatch.setattr(derivatives, "Derivatives", lambda *given: recorded.append(given[5]) or plain(*given))
    pose, options = (
        cantilever.result.configuration,
        {"load": [10, 0, -300, 0, 0, 0], **({} if exactly else {"assembly_errors": {}})},
    )
    for of in (["mass"], ["twist"], ["stiffness", "actuator_forces"], ("mass", "compliance", "actuators")):
        s = ks.sensitivities(pose, ["diameter", "tip_mass"], of, **options)
        assert s.outputs == tuple(name for name in QUANTITIES if name in of) == tuple(s["diameter"].derivatives)
        assert s["diameter"].exact == exactly and set(s.sources) == ({"rod"} if "twist" in of else set())
        for name, quantity in s["diameter"].derivatives.items():
            whole = getattr(cantilever["diameter"], name)
            if name.startswith("actuator"):
                assert quantity == whole == {}  # it has no actuators
            else:
                np.testing.assert_allclose(quantity, whole, rtol=1e-6, atol=1e-6 * np.abs(whole).max(), err_msg=name)
        if exactly:
            assert set(recorded[-1]) == {name for name in of if not name.startswith("actuator")}
        missing = next(name for name in QUANTITIES if name not in of)
        with pytest.raises(ks.ArgumentError, match=f"^{missing} is not among the outputs="):
            getattr(s["diameter"], missing)
        text = str(s)
        assert ("moves o by [" in text) == ("twist" in of) and ("adds" in text) == ("mass" in of)
        assert "diameter" in s._repr_html_()
        assert missing not in s.to_dict()["parameters"]["diameter"] and set(of) < set(s.to_dict()["parameters"]["diameter"])
    assert bool(recorded) == exactly


def test_parameters_without_effect_on_outputs_are_left_out(cantilever):
    s = ks.sensitivities(cantilever.result.configuration, outputs=["mass"])
    # of a rod of 7.9 kg twice one per cent, one and one, and of a tip of 5 kg one
    assert next(iter(s)) == "diameter" and set(s) == {"diameter", "density", "length", "tip_mass"} and list(s)[-1] == "tip_mass"
    assert s.effect("diameter")[1] == pytest.approx(0.02 * 7850 * np.pi * 0.04**2 / 4 * 0.8) and np.isnan(s.effect("length")[0])
    assert s["tip_mass"].mass == pytest.approx(1, rel=1e-9)
    assert set(ks.sensitivities(cantilever.result.configuration, outputs=["compliance"])) == {"diameter", "length", "E"}


def test_batch_effects_are_those_of_the_most_displaced_pose(cantilever):
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": [0.45, 0.6], "rx": 0.0, "ry": 0.0})
    s = ks.sensitivities(pose, ["rod_diameter"], load=LOAD)
    assert s["rod_diameter"].twist.shape == (2, 6) and s["rod_diameter"].mass.shape == (2,) and s.worst == (1,)
    assert s.effect("rod_diameter")[0] < 0 < s.effect("rod_diameter")[1]
    assert "[1] of the batch" in str(s)
    text = str(cantilever)
    assert "stiffen the first" in text and "colour" not in text and "holes" not in text
    assert json.loads(json.dumps(cantilever.to_dict()))["parameters"]["E"]["unit"] == "Pa"
    assert len(cantilever) == 5 and "diameter" in cantilever._repr_html_()


def test_bar_chart_shows_relative_effects(cantilever):
    import matplotlib

    matplotlib.use("Agg")
    ax = ks.plot.sensitivities(cantilever)
    labels = [label.get_text() for label in ax.get_yticklabels()]
    assert set(labels) == {"diameter", "length", "E", "density", "tip_mass", "stiffness of rod"}
    widths = dict(zip(labels, [bar.get_width() for bar in ax.patches], strict=True))
    assert widths["E"] == pytest.approx(-1, rel=1e-6) == pytest.approx(widths["stiffness of rod"], rel=1e-6)
    with pytest.raises(ks.ArgumentError, match="needs the result of"):
        ks.plot.sensitivities(1)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"by": ["rod_diametre"]}, "did you mean 'rod_diameter'"),
        ({"by": "rod_diameter"}, "sequence of names"),
        ({"by": ["rod_1.outer_diametre"]}, r"no parameter 'rod_1.outer_diametre': did you mean 'rod_1.outer_diameter'"),
        ({"outputs": ["mass", "twst"]}, r"outputs is 'twst'; it must be one of 'twist', 'stiffness'"),
        ({"outputs": "mass"}, "outputs is 'mass'; it must be a sequence of names"),
        ({"outputs": []}, "outputs is empty"),
    ],
)
def test_invalid_arguments_are_refused(given, message):
    with pytest.raises(ks.ArgumentError, match=message):
        ks.sensitivities(package_robots.robot("3rps").assemble(), **{"by": ["rod_diameter"], **given})


def test_changed_robots_and_uncomputed_results_are_refused(cantilever):
    pose = cantilever.result.configuration
    with pytest.raises(ks.ArgumentError, match="needs a Configuration"):
        ks.sensitivities(pose.robot)
    with pytest.raises(ks.ArgumentError, match="the batch is empty"):
        ks.sensitivities(package_robots.robot("3rps").assemble(platform={"z": [], "rx": 0.0, "ry": 0.0}))
    changed = ks.Robot(pose.robot.description.changed("rod", density=1000.0))
    with pytest.raises(ks.ArgumentError, match="differs from its file"):
        ks.sensitivities(changed.assemble(), ["diameter"])
    with pytest.raises(ks.ArgumentError, match="no sensitivity was computed for 'rod'"):
        cantilever["rod"]
    import matplotlib

    matplotlib.use("Agg")
    with pytest.raises(ks.ArgumentError, match="sensitivities needs the twist, which is not among the outputs"):
        ks.plot.sensitivities(ks.sensitivities(pose, ["E"], ["mass"]))


def test_rigid_robot_without_parameters_reports_no_sensitivities(tmp_path):
    (tmp_path / "post.urdf").write_text(
        '<robot name="post"><link name="base"/><link name="tip"/><joint name="turn" type="continuous"><parent link="base"/>'
        '<child link="tip"/></joint><platform link="tip"/><transmission name="motor"><joint name="turn"/></transmission></robot>',
        encoding="utf-8",
    )
    found = ks.sensitivities(ks.load_robot(tmp_path / "post.urdf").assemble())
    assert "No part is elastic, and the file has no numbers" in str(found)


def test_loads_in_the_platform_frame_use_differences_of_analyses():
    """Such a load turns with the platform; in the default frame derivatives are exact."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0})
    for frame in ("world", "platform"):
        found = ks.sensitivities(pose, ["youngs_modulus"], ["twist"], load=[0, 300, 0, 0, 0, 0], gravity=(0, 0, 0), frame=frame)
        item = found["youngs_modulus"]
        assert item.exact == (frame == "world")
        np.testing.assert_allclose(item.twist * item.value, -found.result.twist, rtol=1e-6, atol=1e-14)


def test_parameters_whose_change_yields_no_robot_are_skipped():
    """A rod must stay on the line of its slide; other named parameters keep their derivatives."""
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.05, "ry": -0.1})
    found = ks.sensitivities(pose, by=["prismatic_1.placement.y", "revolute_1.placement.x"], load=LOAD)
    assert list(found) == ["revolute_1.placement.x"] and "inside its span" in found.skipped["prismatic_1.placement.y"]
    with pytest.raises(ks.ArgumentError, match=r"^prismatic_1.placement.y: a small change yields no robot: .*rod_1"):
        ks.sensitivities(pose, by=["prismatic_1.placement.y"], load=LOAD)


@pytest.mark.slow
def test_files_with_rounded_angles_keep_the_tolerance_of_their_pose():
    """Five digits of everything: derivatives and spreads are those of the exact robot, to some digits."""
    rounded, exact = odd_robots.rounded_angles(), odd_robots.small.robot_of(odd_robots.small.pru2_upr())
    poses = [rounded.assemble(closure_tolerance=1e-3), exact.assemble()]
    name, how = "rod_1.youngs_modulus", {"load": LOAD, "point": (0, 0, 0)}  # which is done by differences
    one, other = (ks.sensitivities(pose, [name], ["twist"], **how)[name].twist for pose in poses)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-3 * np.abs(other).max())
    one, other = (ks.tolerances(pose, {name: "1%"}, samples=2, seed=1, **how).standard_deviation.twist for pose in poses)
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-3 * np.abs(other).max())


@pytest.mark.parametrize(("change", "noticed"), [(0.9e-7, False), (1.1e-7, True)])
def test_parameters_that_change_nothing_by_a_ten_millionth_have_no_influence(change, noticed):
    """Relative to the parameter, and to the twist, the actuator forces or the mass; to all else if none of them is asked for."""
    whole = {"twist": np.array([0.0, -4.0]), "actuator_forces": np.array([[1e6, 5.0]]), "stiffness": np.ones((6, 6))}
    changes = {
        "twist": np.array([0.0, 4.0 * change / 2]), "actuator_forces": {"a": np.zeros(1), "b": np.array([5.0 * change / 2])},
        "stiffness": np.full((6, 6), change / 2),
    }  # fmt: skip
    for name, slope in changes.items():
        assert _has_influence(Sensitivity("p", -2.0, "m", {name: slope}, True), whole) == noticed
    others = {"twist": np.zeros(2), "stiffness": np.ones((6, 6))}
    assert not _has_influence(Sensitivity("p", -2.0, "m", others, True), whole)


def test_numbers_of_a_pose_are_those_that_are_asked_for():
    pose = package_robots.robot("3rps").assemble()
    for asked in (["twist"], ["actuators"], ["mass", "actuator_forces"]):
        assert set(numbers_of(pose, ks.analyze(pose), None, asked)) == set(asked)
