"""The largest deflection under a force from any direction, against random directions one by one."""

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.design.problem import parse_quantity, parse_requirement


@pytest.mark.few(1)
@pytest.mark.parametrize("orientation", ["tilt_torsion", "XYZ"])
def test_deflection_any_direction_is_the_maximum_over_sampled_directions(orientation):
    robot, tip = package_robots.robot("3rps"), np.array([0.05, -0.02, 0.2])
    angles = {"azimuth": 0.7, "tilt": [0.1, 0.3]} if orientation == "tilt_torsion" else {"rx": 0.2, "ry": [0.1, -0.3]}
    ds = ks.sweep(robot, platform={"z": 0.5, **angles}, orientation=orientation)
    at_o, at_tip = (ks.indices.quantity(item, "deflection_any_direction(500 N)") for item in (ds, ks.indices.at_point(ds, tip)))
    turned = ks.indices.quantity(ds, "rotation_any_direction(20 N·m)")
    pose = robot.assemble(platform={"z": 0.5, **angles}, orientation=orientation)
    directions = np.random.default_rng(2).normal(size=(4000, 1, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    none = np.zeros_like(directions)
    force, moment = np.concatenate([500 * directions, none], axis=-1), np.concatenate([none, 20 * directions], axis=-1)
    result = ks.analyze(pose, force, gravity=(0, 0, 0))
    tried = np.linalg.norm(result.twist[..., :3], axis=-1).max(axis=0)
    assert np.all(tried <= at_o * (1 + 1e-12)) and np.all(tried > 0.995 * at_o)
    arm = np.einsum("nij,j->ni", pose.platform_frame[:, :3, :3], tip)
    result = ks.analyze(pose, force, gravity=(0, 0, 0), point=tip + np.zeros((2, 3)), frame="platform")
    # a load in the platform's frame turns with it: the set of all directions is the same
    moved = result.twist[..., :3] + np.cross(result.twist[..., 3:], arm)
    tried = np.linalg.norm(moved, axis=-1).max(axis=0)
    assert np.all(tried <= at_tip * (1 + 1e-12)) and np.all(tried > 0.995 * at_tip) and np.all(at_tip != at_o)
    result = ks.analyze(pose, moment, gravity=(0, 0, 0))
    tried = np.linalg.norm(result.twist[..., 3:], axis=-1).max(axis=0)
    assert np.all(tried <= turned * (1 + 1e-12)) and np.all(tried > 0.995 * turned)
    named = ks.indices.quantity(ds, "deflection_any_direction:0.5kN")
    np.testing.assert_allclose(named, at_o, rtol=1e-14)
    assert named.attrs["units"] == "m" and "500 N" in named.attrs["long_name"]
    assert ks.indices.worst(ds, "rotation_any_direction:20").value == pytest.approx(float(turned.max()))


def test_maps_and_results_at_point_match_forces_at_tool_tip(tmp_path, capsys):
    robot, tip = package_robots.robot("3rps"), np.array([0.05, -0.02, 0.2])
    over = {"z": [0.5, 0.6], "rx": 0.2, "ry": [0.1, -0.3, 0.0]}
    ds = ks.sweep(robot, platform=over, orientation="XYZ", load=[10, 20, -300, 4, 5, 6])
    z, ry = np.meshgrid(over["z"], over["ry"], indexing="ij")
    pose = robot.assemble(platform={"z": z, "rx": 0.2, "ry": ry}, orientation="XYZ")
    result = ks.analyze(pose, [10, 20, -300, 4, 5, 6])
    seen, there = result.at_point(tip), ks.indices.at_point(ds, tip)
    arm = pose.platform_frame[..., :3, :3] @ tip
    displacement = result.twist[..., :3] + np.cross(result.twist[..., 3:], arm)
    np.testing.assert_allclose(seen.twist, np.concatenate([displacement, result.twist[..., 3:]], axis=-1), atol=1e-18)
    np.testing.assert_allclose(sum(seen.contributions.values()), seen.twist, atol=1e-16)
    # a wrench about the tip, in the world's axes, moves it by its compliance; the stiffness there is its inverse
    wrench = np.array([100.0, -50.0, 70.0, 3.0, -2.0, 1.0])
    at_o = np.concatenate([np.broadcast_to(wrench[:3], arm.shape), wrench[3:] + np.cross(arm, wrench[:3])], axis=-1)
    moved = ks.analyze(pose, at_o, gravity=(0, 0, 0)).at_point(tip).twist
    np.testing.assert_allclose(seen.compliance @ wrench, moved, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(seen.stiffness @ seen.compliance, np.broadcast_to(np.eye(6), (2, 3, 6, 6)), atol=1e-9)
    for name in ("twist", "stiffness", "compliance"):
        found, wanted = there[name].values, getattr(seen, name)
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * np.abs(wanted).max(), err_msg=name)
    sags = ks.indices.quantity(there, "linear_sag")
    np.testing.assert_allclose(sags, np.linalg.norm(displacement, axis=-1), rtol=1e-12)
    with pytest.raises(ks.ArgumentError, match="another reference point than o already"):
        ks.indices.at_point(there, tip)
    ds.to_netcdf(tmp_path / "map.nc")
    command = ["plot", str(tmp_path / "map.nc"), *"--kind line --x ry --at z=0.5 --out".split(), str(tmp_path / "tip.svg")]
    assert main([*command, "--tool", "5cm", "-2cm", "200mm"]) == 0 and "wrote" in capsys.readouterr().out
    assert main([*command, "--tool", "5kg", "0", "0"]) == 2 and "--tool" in capsys.readouterr().err


@pytest.mark.few(1)
@pytest.mark.parametrize("written", ["{}({} {})", "{}:{}{}", " {} ( {}{} ) ", "{}: {} {}"])
def test_maps_and_requirements_accept_the_same_spellings(written):
    """With a colon or brackets, with spaces or without; names listed for a map are accepted as well."""
    ds = ks.sweep(package_robots.robot("3rps"), platform={"z": [0.5], "rx": 0.0, "ry": 0.0})
    for name, size, unit in (("deflection_any_direction", 0.5, "kN"), ("rotation_any_direction", 20, "Nm")):
        text = written.format(name, size, unit)
        value = ks.indices.quantity(ds, text)
        part = slice(3) if unit == "kN" else slice(3, 6)
        largest = np.linalg.eigvalsh(ds.compliance.values.squeeze()[part, part])[-1]
        assert float(value.squeeze()) == pytest.approx((500 if unit == "kN" else 20) * largest, rel=1e-12)
        assert parse_quantity(text) == (name, 500 if unit == "kN" else 20)
        requirement = parse_requirement(f"{text} < 3e-5")
        assert (requirement.name, requirement.argument, requirement.limit) == (*parse_quantity(text), 3e-5)
    shown = [name for name in ks.indices.names(ds) if "any_direction" in name]
    assert shown == ["deflection_any_direction(500 N)", "rotation_any_direction(20 N·m)"]
    assert all(np.isfinite(ks.indices.quantity(ds, name)).all() for name in shown)


def test_invalid_sizes_and_points_are_refused():
    ds = ks.sweep(package_robots.robot("3rps"), platform={"z": [0.5], "rx": 0.0, "ry": 0.0})
    for what in ("deflection_any_direction:5mm", "rotation_any_direction(5N)", "deflection_any_direction:much"):
        with pytest.raises(ks.ArgumentError, match=r"is not a size in .*, such as .*_any_direction\((500 N|20 N·m)\)"):
            ks.indices.quantity(ds, what)
    with pytest.raises(ks.ArgumentError, match=r"write it with its size, deflection_any_direction\(500 N\)"):
        ks.indices.quantity(ds, "deflection_any_direction")
    with pytest.raises(ks.ArgumentError, match="three numbers"):
        ks.indices.at_point(ds, (0, 0))
    with pytest.raises(ks.ArgumentError, match="is not a size in"):
        ks.indices.quantity(ds, "rotation_any_direction(0)")
