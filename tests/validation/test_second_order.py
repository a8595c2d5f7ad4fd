"""Results of second order and load factors against closed forms, finite elements and OpenSees."""

import json
import subprocess
import sys
from pathlib import Path

import energy_model
import numpy as np
import package_robots
import pytest
import small_robots as sr
from energy_structure import structure_of
from mechanisms import Joint, Link
from places import CASES
from small_robots import E

import kinetostatics as ks
from kinetostatics.statics.second_order import tangent_of
from kinetostatics.statics.springs import unstable_motions

SECTION = sr.Section(2e-3, 4e-7, 4e-7, 6e-7)
EI, L = E * 4e-7, 1.5
STIFF = sr.Section(200.0, 4e-7, 4e-7, 6e-7)  # along its axis
MAST = sr.cantilever(L, (0, 0, 1), section=STIFF, y_axis=(0, 1, 0), density=0.0, kappa=np.inf)


def analyzed(spec, load, gravity=(0, 0, 0), **options):
    return ks.analyze(sr.robot_of(spec).assemble(), load, gravity, **options)


def change(result):
    return result.second_order.twist - result.twist


@pytest.mark.parametrize("part", [1e-6, 0.3, 0.9, 0.999, -0.5, -3.0])
def test_column_under_side_load_equals_closed_form(part):
    """Timoshenko and Gere, section 1.11: 3 (tan kL − kL) / (kL)³ times the deflection, 2 (1 / cos kL − 1) / (kL)² the slope.

    The tip sinks by ½ ∫ v′² ds.
    """
    pressure, side = part * np.pi**2 * EI / (2 * L) ** 2, 10.0
    found, kl = analyzed(MAST, (side, 0, -pressure, 0, 0, 0)), np.sqrt(complex(pressure / EI)) * L
    deflection, slope = (3 * (np.tan(kl) - kl) / kl**3).real - 1, (2 * (1 / np.cos(kl) - 1) / kl**2).real - 1
    shorter = 3 * abs(pressure / (E * STIFF.area) / (1 - part))  # by P / EA, which Euler's theory neglects
    linear = np.array([side * L**3 / (3 * EI), side * L**2 / (2 * EI)])
    np.testing.assert_allclose(change(found)[[0, 4]] / linear, [deflection, slope], rtol=shorter + 1e-8, atol=1e-10)
    assert (np.abs(change(found)[[1, 3, 5]]) < 1e-6 * np.abs(found.second_order.twist).max()).all()  # rounding
    s = np.linspace(0, L, 2001)
    slopes = (side / pressure * (np.cos(kl * (1 - s / L)) / np.cos(kl) - 1)).real
    assert change(found)[2] == pytest.approx(-np.trapezoid(slopes**2, s) / 2, rel=0.05)
    lateral = 4.01260 * np.sqrt(EI / found.robot.statics.beams["arm"].compliances[3]) / L**2 / side
    expected = 1 / part if part > 1e-3 else lateral
    if part > -0.1:  # tension stabilizes it
        assert float(found.buckling().load_factors[0]) == pytest.approx(expected, rel=1e-2 if part < 1e-3 else 1e-6)
    assert np.any(["change the stiffness" in text for text in found.warnings]) == (abs(part) > 0.01)
    loaded = found.second_order
    assert loaded.change == pytest.approx(-part, rel=0.05, abs=1e-4)  # the stiffness against the mode: 1 − P / P_Euler


def test_column_under_uniform_load_equals_closed_form():
    """EI w″ = P (δ − w) + q (L − x)² / 2 with w(0) = w′(0) = 0 and w(L) = δ; the mode is 1 − cos."""
    density, pressure = 0.0785, 0.5 * np.pi**2 * EI / (2 * L) ** 2
    found = analyzed(sr.with_beams(MAST, density=density), (0, 0, -pressure, 0, 0, 0), gravity=(9.81, 0, 0))
    q, k = density * STIFF.area * 9.81, np.sqrt(pressure / EI)
    kl = k * L
    top = q / pressure * ((kl * np.sin(kl) - 1) / np.cos(kl) + 1 - kl**2 / 2) / k**2
    assert float(change(found)[0]) == pytest.approx(top - q * L**4 / (8 * EI), rel=5e-8)  # the column shortens by P / EA
    line = found.buckling().beam_lines["arm"][0, :, :3]
    line = np.linalg.norm(line, axis=1) / np.linalg.norm(line[-1])
    np.testing.assert_allclose(line, 1 - np.cos(np.pi / 2 * np.linspace(0, 1, 21)), atol=1e-6)


def two_bars(rise):
    """Two bars between hinges hold a platform that slides along z alone."""
    guide = sr.Limb((Joint("way", "P", (0, 0, rise), (0, 0, 1)), Joint("fixed", "F", (0, 0, rise))), (Link("carriage"),))
    limbs, beams = [guide], []
    for k, x in ((1, -1.0), (2, 1.0)):
        hinges = (Joint(f"foot_{k}", "R", (x, 0, 0), (0, 1, 0)), Joint(f"head_{k}", "R", (0, 0, rise), (0, 1, 0)))
        limbs.append(sr.Limb(hinges, (Link(f"bar_{k}"),)))
        beams.append(sr.Beam(f"bar_{k}", f"bar_{k}", f"foot_{k}", f"head_{k}", SECTION, y_axis=(0, 1, 0), density=0.0))
    return sr.Spec(tuple(limbs), tuple(beams), o=(0, 0, rise))


@pytest.mark.parametrize("load", [-200.0, 300.0])
def test_shallow_frame_of_two_bars_equals_closed_form(load):
    """Its force is 2 EA (1 − l₀ / l) h / l₀ at the height h: stiffness and displacement to second order in the load."""
    rise = 0.05
    found, length = analyzed(two_bars(rise), (0, 0, load, 0, 0, 0)), np.hypot(1, rise)
    sine, EA = rise / length, E * SECTION.area
    linear, geometric = 2 * EA * sine**2 / length, load / sine * (1 - sine**2) / length
    change = 3 * (1 - sine**2) / rise * load / linear  # of the stiffness, relative to it
    assert float(found.compliance[2, 2]) == pytest.approx(1 / linear, rel=1e-6)
    assert 1 / float(found.second_order.compliance[2, 2]) / linear - 1 == pytest.approx(change, rel=0.02)
    assert float(found.second_order.twist[2]) / (load / linear) - 1 == pytest.approx(-change / 2, rel=0.02)
    assert found.second_order.change == pytest.approx(change, rel=0.02)
    factors = found.buckling(9).load_factors
    if load < 0:
        assert np.min(np.abs(factors[np.isfinite(factors)] / (-linear / geometric) - 1)) < 1e-4


def agree(mine, theirs, unit, share):
    assert np.abs((mine - theirs) * unit).max() <= share * np.abs(theirs * unit).max()


@pytest.mark.few(6)
@pytest.mark.parametrize("moments", [0.0, 1.0])
@pytest.mark.parametrize("name", package_robots.NAMES)
def test_tangent_at_the_pose_is_the_second_derivative_of_energy(name, moments):
    """All section forces, and joint forces and moments, at the unloaded geometry; an independent model of the same robot."""
    pose = package_robots.generic_pose(name)
    load = np.array([300.0, -200.0, -400.0, *(moments * np.array([40.0, -60.0, 50.0]))])
    load *= min(1.0, 0.02 / np.abs(ks.analyze(pose, load, (0, 0, 0)).twist[3:]).max())
    result = ks.analyze(pose, load)
    found = tangent_of(pose.robot.statics, pose.robot.members.structure.rotation_groups, result.solutions[0])
    expected = energy_model.at_the_pose(structure_of(pose, load))
    unit = np.repeat([1.0, pose.robot.length], 3)
    agree(found.compliance[..., 0], expected.compliance, np.outer(unit, unit), 1e-6)
    agree(found.twist[:, 0], expected.twist, unit, 1e-6)


@pytest.mark.parametrize("load", [(0, 0, 0, 0, 0.5, 0), (0, 0, 0, 0, 0.25, 0), (6, 0, 0, 0, 0, 0), (3, 4, 50, 0.1, -0.1, 0)])
def test_second_order_of_a_soft_robot_equals_a_model_with_large_rotations(load):
    pose = package_robots.robot("linear_delta").assemble()
    result, expected = ks.analyze(pose, load), energy_model.in_equilibrium(structure_of(pose, load))
    unit = np.repeat([1.0, pose.robot.length], 3)
    found = result.second_order
    agree(found.twist, expected.twist, unit, 0.02)
    agree(found.compliance, expected.compliance, np.outer(unit, unit), 0.02)
    softness = np.diag(expected.compliance)[3:5]
    np.testing.assert_allclose(np.diag(found.compliance)[3:5], softness, rtol=0.02)
    assert any("change the stiffness" in text for text in result.warnings)


BEND = sr.locked_chain(
    [(0, 0, 0), (0, 0, 1.0), (0.008, 0.002, 1.8)], [(1, 0, 0), (0, 1, 0)], section=SECTION, kappa=np.inf, density=0.0
)
PORTAL = sr.with_beams(sr.portal(section=SECTION), kappa=np.inf, density=0.0, y_axis=(0, 1, 0))
FRAMES = {  # nodes, beams (from, to, stiff), tip, load
    "bend": (BEND, [(0, 0, 0), (0, 0, 1), (0.008, 0.002, 1.8)], [(0, 1, 0), (1, 2, 0)], 2, (4, 6, -3e4)),
    "portal": (
        PORTAL,
        [(-0.4, 0, 0), (0.4, 0, 0), (-0.4, 0, 1), (0.4, 0, 1), (0, 0, 1)],
        [(0, 2, 0), (1, 3, 0), (2, 4, 1), (4, 3, 1)],
        4,
        (20, 30, -2e5),
    ),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("transformation", ["PDelta", "Corotational"])
@pytest.mark.parametrize("name", FRAMES)
def test_second_order_equals_opensees(name, transformation):
    """Elements that follow their chords, 16 to a beam, loads in 10 steps with equilibrium in the displaced state."""
    spec, nodes, beams, tip, load = FRAMES[name]
    given = {"nodes": nodes, "beams": beams, "tip": tip, "load": load, "E": E, "section": [SECTION.area, 4e-7, 4e-7, 6e-7]}
    code = (Path(__file__).parents[1] / "support" / "opensees_second_order.py").read_text(encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", code, transformation],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    )
    found, nonlinear = analyzed(spec, (*load, 0, 0, 0)), np.array(json.loads(done.stdout.splitlines()[-1]))
    assert np.linalg.norm(change(found)) > 0.2 * np.linalg.norm(found.twist)
    scale = np.abs(found.second_order.twist).max()
    np.testing.assert_allclose(found.second_order.twist, nonlinear, rtol=0, atol=5e-3 * scale)


def test_second_order_of_rotated_robots_batches_and_points():
    """The whole robot turned with its gravity and load; a batch is its poses; about a tool's tip the twist is that of the tip."""
    spec, load = sr.puu3(), np.array([30.0, -20.0, -400.0, 2.0, -3.0, 5.0])
    R = sr.random_rotation(np.random.default_rng(1))
    turned = analyzed(sr.rotated(spec, R), np.kron(np.eye(2), R) @ load, R @ [0, 0, -9.81])
    pose = sr.robot_of(spec).assemble()
    found = ks.analyze(pose, [load, 1e-6 * load, 1e6 * load], on_failure="nan")
    rows = {"buckling": found.buckling(2).load_factors, "shapes": found.buckling(2).twists, "loaded": found.second_order.twist}
    one = ks.analyze(pose, load)
    np.testing.assert_allclose(rows["buckling"][0], one.buckling(2).load_factors, rtol=1e-9)
    np.testing.assert_allclose(rows["shapes"][0], one.buckling(2).twists, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(rows["loaded"][0], one.second_order.twist, rtol=1e-9)
    assert np.isnan(rows["loaded"][2]).all() and rows["buckling"][2, 0] < 1
    np.testing.assert_allclose(turned.buckling(2).load_factors, rows["buckling"][0], rtol=1e-7)
    np.testing.assert_allclose(turned.second_order.twist, np.kron(np.eye(2), R) @ rows["loaded"][0], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(one.second_order.stiffness @ one.second_order.compliance, np.eye(6), atol=1e-6)
    np.testing.assert_allclose(one.second_order.stiffness, one.second_order.stiffness.T, rtol=1e-12)
    tip = np.array([0.1, 0.2, 0.3])
    moved, arm = one.at_point(tip).second_order, pose.platform_frame[:3, :3] @ tip
    twist = one.second_order.twist
    np.testing.assert_allclose(moved.twist[:3], twist[:3] + np.cross(twist[3:], arm), rtol=1e-9)
    assert ks.analyze(pose, np.zeros((0, 6))).second_order.stiffness.shape == (0, 6, 6)


def test_portal_mode_is_sway_of_both_columns():
    """Without rotation of its ends each column is a half wave; both have half of the energy."""
    spec = sr.with_beams(sr.portal(section=SECTION), kappa=np.inf, density=0.0, y_axis=(0, 1, 0))
    found = analyzed(spec, (0, 0, -1e3, 0, 0, 0))
    modes = found.buckling(2)
    shares = np.array([*modes.energy_shares.values()])
    np.testing.assert_allclose(shares, 0.5, rtol=1e-6)
    assert set(modes.members[:]) <= {"column_1", "column_2"}
    lines = modes.beam_lines["column_1"][0]
    np.testing.assert_allclose(lines[-1, :3], modes.twists[0, :3], atol=1e-3 * np.abs(modes.twists[0, :3]).max())
    assert "394.8  column_1                          50.0" in str(modes) and "394.8" in str(found.report().only("buckling"))


def test_load_factor_without_compression_is_infinite_and_not_printed():
    found = analyzed(MAST, (0, 0, 1e3, 0, 0, 0))
    assert np.all(found.buckling(3).load_factors == np.inf)
    assert "None: the robot buckles under no multiple" in str(found.report().only("buckling"))
    assert "inf" not in str(found.buckling(3))


def test_unstable_springs_have_no_second_order_and_mode_count_zero_is_refused():
    assert np.isnan(ks.analyze(ks.load_robot(CASES / "unstable_inside_a_limb.urdf").assemble()).second_order.twist).all()
    with pytest.raises(ks.ArgumentError, match="count is 0; it must be a whole number from 1 on"):
        analyzed(MAST, (0, 0, -1, 0, 0, 0)).buckling(0)


# ---- moments ---------------------------------------------------------------------------------------------------------------


def stable_under(spec, load):
    pose = sr.robot_of(spec).assemble()
    solution = ks.analyze(pose, load, (0, 0, 0)).solutions[0]
    return not unstable_motions(
        tangent_of(pose.robot.statics, pose.robot.members.structure.rotation_groups, solution).tangents, 1
    )[0]


@pytest.mark.parametrize(
    ("load", "tall", "factor"),
    [
        ((1, 0, 0, 0, 0, 0), False, None),
        ((0, 0, 0, 1, 0, 0), True, np.pi),
        ((0, 0, 0, 0, 0, 1), False, np.pi),
        ((0, 1, 0, 0, 0, 0), True, 4.0126),
    ],
    ids=["side force on a round column", "end moment", "torque", "side force on a tall section"],
)
def test_cantilever_under_moments_buckles_at_the_closed_form(load, tall, factor):
    """Lateral-torsional buckling under an end moment, π √(EI GJ) / L, or a side force, 4.013 √(EI GJ) / L² (Timoshenko and Gere,
    section 6.3); Greenhill's shaft under a torque, π EI / L. The moments are semitangential."""
    section = sr.Section(200.0, 4e-7, 4e-2 if tall else 4e-7, 6e-7)
    spec = sr.cantilever(L, (0, 0, 1), section=section, y_axis=(0, 1, 0), density=0.0)
    pose = sr.robot_of(spec).assemble()
    twisting = 1 / pose.robot.statics.beams["arm"].compliances[3]
    if factor is None:
        assert stable_under(spec, np.array(load) * 1e4)
        return
    size = factor * (EI if load[5] else np.sqrt(EI * twisting)) / L ** (2 if any(load[:3]) else 1)
    assert stable_under(spec, np.array(load) * 0.9999 * size)
    assert not stable_under(spec, np.array(load) * 1.0001 * size)
    result = ks.analyze(pose, np.array(load) * 1.0001 * size, (0, 0, 0))
    assert np.isnan(result.second_order.twist).all() and result.buckles
    assert result.buckling().load_factors[0] == pytest.approx(1 / 1.0001, rel=1e-5)
    assert "the forces are 100 % of the buckling load of beam arm: no result applies" in result.warnings
