"""Capacity: closed forms of a cantilever and a strut, one limit reached exactly, no force that the worst direction beats."""

from dataclasses import replace

import numpy as np
import package_robots
import pytest
from places import CASES
from simple_machines import E, joint, link, robot, two_columns

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.exceptions import ArgumentError

YIELD, DIAMETER, LENGTH = 250e6, 0.05, 1.0
AREA, I = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64  # noqa: E741


def column(strength=f' yield_strength="{YIELD}"', shear="inf"):
    """A massless vertical column, clamped at its foot, with the platform at its head."""
    beam = (
        f'<beam link="rod" from="foot" to="head" youngs_modulus="{E}" poisson_ratio="0.3" density="0" shear_coefficient="{shear}"'
        f'{strength}><circle diameter="{DIAMETER}"/></beam>'
    )
    parts = [link("base"), link("rod"), link("platform"), joint("foot", "fixed", "base", "rod")]
    return robot(*parts, joint("head", "fixed", "rod", "platform", f"0 0 {LENGTH}"), beam)


def strong(name, strength):
    description = package_robots.robot(name).description
    for beam in description.beams:
        description = description.changed(beam, yield_strength=strength)
    return ks.Robot(description)


def test_column_yields_under_tension_at_the_area_times_its_strength():
    found = ks.capacity(column().assemble(), [0, 0, 1, 0, 0, 0], gravity=(0, 0, 0))
    np.testing.assert_allclose(found.load, AREA * YIELD, rtol=1e-12)
    assert found.limited_by == "yield of rod" and found.unit == "1"


def test_cantilever_carries_less_across_than_its_bending_strength():
    """At the clamp σ = M D/2I; the shear stress vanishes at the outermost fibre, where σ is largest."""
    found = ks.capacity(column().assemble(), gravity=(0, 0, 0))
    across = YIELD * I / (LENGTH * DIAMETER / 2)
    along = AREA * YIELD
    worst = 1 / np.hypot(1 / across, 1 / along)  # the largest of F (sin/across + cos/along) over all directions
    np.testing.assert_allclose(found.load, worst, rtol=1e-9)
    assert found.limited_by == "yield of rod" and found.unit == "N"
    np.testing.assert_allclose(abs(found.direction[2]), across / np.hypot(across, along), rtol=1e-4)


def test_column_without_strength_buckles_at_eulers_load():
    found = ks.capacity(column(strength="").assemble(), [0, 0, -1, 0, 0, 0])
    np.testing.assert_allclose(found.load, np.pi**2 * E * I / (2 * LENGTH) ** 2, rtol=1e-6)
    assert found.limited_by == "buckling of rod"
    pulled = ks.capacity(column(strength="").assemble(), [0, 0, 1, 0, 0, 0])
    assert np.isinf(pulled.load) and pulled.limited_by == ""


def test_mass_is_the_force_divided_by_gravity_and_sag_is_linear():
    pose = column().assemble()
    mass = ks.capacity(pose, payload=ks.Payload(1.0, center=(0, 0, 0.3)), sag=1e-5)
    np.testing.assert_allclose(mass.load, 1e-5 * E * AREA / LENGTH / 9.81, rtol=1e-11)
    assert mass.limited_by == "sag" and mass.unit == "kg" and mass.direction is None
    beside = ks.capacity(pose, payload=ks.Payload(1.0, center=(0.1, 0, 0)))
    np.testing.assert_allclose(beside.load, YIELD / (9.81 / AREA + 9.81 * 0.1 * DIAMETER / 2 / I), rtol=1e-11)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["3rps", "gough_stewart", "delta", "2pru_upr"])
def test_exactly_one_limit_is_reached_at_the_returned_load(name):
    """At random poses, under random wrenches: the safety factor of the named limit is 1, no other is smaller."""
    made = strong(name, 50e6)
    rng = np.random.default_rng(4)
    actuators = {joint: rng.uniform(-0.02, 0.02, 5) for joint in made.description.actuated}
    pose = made.assemble(actuators=actuators)
    wrenches = rng.normal(size=(5, 6)) * np.repeat([1.0, 0.1], 3)
    found = ks.capacity(pose, wrenches, sag=2e-3)
    again = ks.analyze(pose, load=found.load[:, None] * wrenches)
    for k, limit in enumerate(found.limited_by):
        factors = {name: float(factor[k]) for name, factor in again.margins.safety_factors.items()}
        factors["sag"] = 2e-3 / float(np.linalg.norm(again.twist[k, :3]))
        assert min(factors.values()) == pytest.approx(1, abs=1e-9) and factors[limit] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize(("name", "sag"), [("3rps", 1e-6), ("delta", None), ("gough_stewart", None)])
@pytest.mark.few(1)
def test_no_force_beats_the_worst_direction(name, sag):
    pose = strong(name, 20e6).assemble()
    found = ks.capacity(pose, sag=sag)
    directions = np.random.default_rng(1).normal(size=(60, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    others = ks.capacity(pose, np.pad(directions, ((0, 0), (0, 3))), sag=sag)
    assert 0 < found.load <= others.load.min()
    np.testing.assert_allclose(ks.capacity(pose, found.direction, sag=sag).load, found.load, rtol=1e-12)


def test_symmetric_robot_has_a_symmetric_capacity():
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.0, "ry": 0.0})
    angle = np.radians(25) + np.array([0, 2, 4]) * np.pi / 3
    forces = np.array([np.cos(angle), np.sin(angle), -2 * np.ones(3), *np.zeros((3, 3))]).T
    loads = ks.capacity(pose, forces, sag=1e-4).load
    np.testing.assert_allclose(loads, loads[0], rtol=1e-9)


def test_nothing_may_be_added_where_a_limit_is_exceeded():
    pose = package_robots.robot("3rps").assemble()
    found = ks.capacity(pose, [0, 0, -1, 0, 0, 0], load=[0, 0, -1e5, 0, 0, 0])
    assert found.load == 0 and found.limited_by.startswith("effort of prismatic_")
    assert any("is beyond the limit of effort of 2000 N" in words for words in found.warnings)


def test_poses_out_of_reach_have_no_capacity():
    five_bar = package_robots.robot("five_bar")
    home = {name: float(value) for name, value in five_bar.assemble().platform.items() if name in ("x", "y")}
    pose = five_bar.assemble(platform={"x": [home["x"], 9.0], "y": home["y"]})
    assert list(pose.reached) == [True, False]
    for found in (ks.capacity(pose, payload=ks.Payload(1.0)), ks.capacity(pose, [0, 0, -1, 0, 0, 0])):
        assert np.isfinite(found.load[0]) and np.isnan(found.load[1]) and found.limited_by[1] == ""


def test_capacity_is_unknown_where_forces_are_undetermined():
    """Two rigid actuators share the load along x in an unknown ratio; nothing limits one without an effort."""
    one = ks.load_robot(CASES / "two_rigid.urdf").description.changed("s", effort=0.0)
    free = ks.capacity(ks.Robot(one).assemble(), [1, 0, 0, 0, 0, 0])
    assert np.isinf(free.load) and free.limited_by == "" and np.isnan(free.result.margins.smallest)
    assert "nothing limits" in repr(free)
    both = replace(one.changed("s", effort=100.0), actuated=("s", "r"))
    found = ks.capacity(ks.Robot(both).assemble(), [1, 0, 0, 0, 0, 0])
    assert np.isnan(found.load) and found.limited_by == "" and repr(found).endswith("unknown>")
    assert np.isnan(found.result.margins.smallest)


def test_arguments_of_a_capacity_are_checked():
    pose = two_columns().assemble()
    with pytest.raises(ArgumentError, match="direction= or payload=, not both"):
        ks.capacity(pose, [0, 0, 1, 0, 0, 0], payload=ks.Payload(1.0))
    with pytest.raises(ArgumentError, match="direction= is zero"):
        ks.capacity(pose, [0, 0, 0, 0, 0, 0])
    with pytest.raises(ArgumentError, match="needs a Configuration"):
        ks.capacity("3rps")
    with pytest.raises(ArgumentError, match="must be the same at all poses"):
        ks.capacity(pose, loads={"a": np.zeros((3, 6))})


def test_map_of_the_payload_has_the_capacity_of_each_pose():
    z = np.array([0.45, 0.5])
    ds = ks.sweep("3rps", {"z": z, "rx": 0.1, "ry": 0.0}, outputs=("capacity", "limits"))
    pose = package_robots.robot("3rps").assemble(platform={"z": z, "rx": 0.1, "ry": 0.0})
    np.testing.assert_array_equal(ds["payload_capacity"], ks.capacity(pose, payload=ks.Payload(1.0)).load)
    result = ks.analyze(pose)
    np.testing.assert_allclose(ds["safety_factor"], result.margins.smallest, rtol=1e-12)
    meanings = ds["limited_by"].attrs["flag_meanings"].split()
    named = [meanings[list(ds["limited_by"].attrs["flag_values"]).index(k)] for k in ds["limited_by"].values]
    assert named == [name.replace(" ", "_") for name in result.margins.limited_by]
    np.testing.assert_allclose(ks.indices.quantity(ds, "largest_utilization"), 1 / result.margins.smallest, rtol=1e-12)


def test_command_prints_the_capacity_and_draws_it(capsys, tmp_path):
    assert (
        main(["capacity", "3rps", "--direction", "0", "0", "-1", "0", "0", "0", "--sag", "50um", "--out", f"{tmp_path}/c.svg"])
        == 0
    )
    out = capsys.readouterr().out
    assert "times the given wrench, limited by effort of prismatic_1" in out and "wrote" in out
    assert "effort of prismatic_1" in (tmp_path / "c.svg").read_text()
    assert main(["capacity", "3rps", "--mass", "--payload-center", "0", "0", "-200mm"]) == 0
    assert "a mass of up to 482.1" in capsys.readouterr().out
