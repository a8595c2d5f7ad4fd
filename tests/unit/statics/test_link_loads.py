"""Loads on links and payloads: superposition, virtual work, comparison with welded masses, base reactions, wrong arguments."""

from dataclasses import replace

import numpy as np
import pytest
import simple_machines as sm
import small_robots
from package_robots import generic_pose as pose
from package_robots import rates, rigid_links, robot

import kinetostatics as ks
from kinetostatics.cli.main import main
from kinetostatics.math import arrays
from kinetostatics.viewer.scene import describe_scene

NO_GRAVITY = (0, 0, 0)


def close(a, b, tolerance=1e-11):
    a, b = np.asarray(a), np.asarray(b)
    np.testing.assert_allclose(a, b, rtol=tolerance, atol=tolerance * np.abs(b).max(initial=1e-30))


def test_load_on_platform_link_equals_platform_load():
    at, wrench, where = pose("2pru_upr"), np.array([10.0, -20, 30, 1, 2, -3]), np.array([0.1, 0.2, -0.3])
    R, o = at.platform_frame[:3, :3], at.platform_frame[:3, 3]
    usual = ks.analyze(at, wrench, point=o + R @ where)
    found = ks.analyze(at, loads={"platform": ks.LinkLoad(wrench, where)})
    close(found.twist, usual.twist)
    close(found.contributions["load on platform"], usual.contributions["load"])
    close(found.platform_wrench, usual.platform_wrench)
    for name, force in usual.actuator_forces.items():
        close(found.actuator_forces[name], force)
    turned = np.concatenate([R.T @ wrench[:3], R.T @ wrench[3:]])
    close(ks.analyze(at, loads={"platform": ks.LinkLoad(turned, where, "link")}).twist, usual.twist)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("name", "link", "place"),
    [
        ("2pru_upr", "slider_1", (0.02, -0.03, 0.05)),  # rigid, inside a limb
        ("3rps", "cylinder_2", (0.02, 0.0, 0.1)),  # in the middle of a telescope
        ("delta", "elbow_1", (0.0, 0.01, 0.0)),  # in a ring
        ("2pru_upr", "platform", (0.05, 0.0, -0.2)),
    ],
)
def test_a_payload_is_a_mass_welded_to_its_link(name, link, place):
    at = pose(name)
    heavy = ks.Robot(at.robot.description.with_payload("tool", link, 7.0, place))
    wanted = ks.analyze(heavy.configuration(at.q, closure_tolerance=1e-9))
    found = ks.analyze(at, payload=ks.Payload(7.0, place, link=link))
    close(found.twist, wanted.twist, 1e-9)
    close(found.base_wrench, wanted.base_wrench, 1e-9)
    for joint, wrench in found.joint_wrenches.items():
        np.testing.assert_allclose(wrench, wanted.joint_wrenches[joint], atol=1e-8)
    for key, beam in found.beams.items():
        np.testing.assert_allclose(beam.deflections, wanted.beams[key].deflections, atol=1e-13)
    bare = ks.analyze(at)
    part = wanted.twist - bare.twist  # at a link that the base carries: rounding
    np.testing.assert_allclose(found.contributions["payload"], part, rtol=1e-8, atol=1e-12 * np.abs(wanted.twist).max())
    for limb in bare.limbs:
        close(found.contributions[limb], bare.contributions[limb])


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["2pru_upr", "delta", "tricept"])
def test_link_loads_superpose_and_satisfy_betti_and_clapeyron(name):
    """Betti: each load's work on the displacements of another equals the reverse; Clapeyron: strain energy is half the work."""
    at = pose(name)
    links = rigid_links(at.robot)
    rng = np.random.default_rng(4)
    loads = {link: np.append(rng.normal(size=3) * 100, np.zeros(3)) for link in dict.fromkeys((links[0], links[-1], "platform"))}
    wrench = rng.normal(size=6) * 100
    found = ks.analyze(at, wrench, NO_GRAVITY, loads=loads)
    close(sum(found.contributions.values()), found.twist)
    close(sum(part for kind in found.source_contributions.values() for part in kind.values()), found.twist, 1e-8)
    for joint, parts in found.joint_contributions.items():
        np.testing.assert_allclose(sum(parts.values()), found.joint_wrenches[joint], atol=1e-8)
    close(sum(limb.wrench for limb in found.limbs.values()), found.platform_wrench, 1e-9)
    for limb in found.limbs.values():
        close(sum(limb.attached_contributions.values()), limb.attached_intensities)
    # about the links' own origins
    acting = {f"load on {link}": (link, load) for link, load in loads.items()}

    def work(load, moved):
        link, force = acting[load]
        return float(force @ found.link_contributions[link][moved])

    names = list(acting)
    for one in names:
        for other in names:
            assert work(one, other) == pytest.approx(work(other, one), rel=1e-8, abs=1e-15)
        assert work(one, "load") == pytest.approx(float(wrench @ found.contributions[one]), rel=1e-8, abs=1e-15)
    total = sum(work(one, other) for one in names for other in [*names, "load"]) + float(wrench @ found.twist)
    assert float(found.strain_energy) == pytest.approx(total / 2, rel=1e-9)


def test_base_wrench_balances_loads_on_all_links():
    at = pose("2pru_upr")
    loads = {link: [3.0, -2.0, 5.0, 0.5, 0.2, -0.1] for link in ("base", "platform", *rigid_links(at.robot)[:1])}
    found, bare = ks.analyze(at, loads=loads), ks.analyze(at)
    total = np.zeros(6)
    for link, load in loads.items():
        wrench = np.array(load)
        total += np.append(wrench[:3], wrench[3:] + np.cross(at.frame(link)[:3, 3] - at.frame("base")[:3, 3], wrench[:3]))
    close(found.base_wrench - bare.base_wrench, -total, 1e-9)
    close(found.contributions["load on base"], np.zeros(6))


def test_beams_accept_loads_only_at_their_ends():
    at = pose("3rps")
    bare = ks.analyze(at)
    beam, frame = bare.beams["rod_2"], at.frame("rod_2")
    ends = [frame[:3, :3].T @ (point - frame[:3, 3]) for point in beam.points[[0, -1]]]
    force = np.array([40.0, -10, 20])
    found = ks.analyze(at, loads={"rod_2": [ks.LinkLoad([*force, 0, 0, 0], end) for end in ends]}, gravity=NO_GRAVITY)
    close(found.base_wrench[:3], -2 * force, 1e-9)
    axis, outer = beam.axes[:, 0], found.limbs["limb_2"].wrench[:3]
    close(found.joint_wrenches["revolute_2"][:3], -(outer + 2 * force), 1e-9)
    assert float(found.beams["rod_2"].section_wrenches[0, 0]) == pytest.approx(float(axis @ (outer + force)), rel=1e-9)
    assert float(found.actuator_forces["prismatic_2"]) == pytest.approx(-float(axis @ (outer + 2 * force)), rel=1e-9)
    middle = (ends[0] + ends[1]) / 2
    with pytest.raises(
        ks.ArgumentError, match=r"load on rod_2: 'rod_2' is elastic, and .* is no end of its beam: .*split the beam"
    ):
        ks.analyze(at, loads={"rod_2": ks.LinkLoad([1, 0, 0, 0, 0, 0], middle)})


def test_batch_of_loads_and_poses_equals_single_analyses():
    one = robot("2pru_upr")
    z = np.array([0.55, 0.6, 0.65])
    at = one.assemble(platform={"z": z, "rx": 0.05, "ry": -0.1})
    link = rigid_links(one)[0]
    loads, mass, centre = np.arange(12.0).reshape(2, 1, 6), np.array([[2.0], [5.0]]), [0.1, 0.0, -0.2]
    found = ks.analyze(at, loads={link: loads}, payload=ks.Payload(mass, centre))
    assert found.shape == (2, 3)
    coefficients = found.payload_coefficients
    for row in range(2):
        for column in range(3):
            here = one.assemble(platform={"z": z[column], "rx": 0.05, "ry": -0.1})
            alone = ks.analyze(here, loads={link: loads[row, 0]}, payload=ks.Payload(mass[row, 0], centre))
            close(found.twist[row, column], alone.twist, 1e-9)
            close(coefficients.twist[row, column], alone.payload_coefficients.twist, 1e-9)


@pytest.mark.parametrize("order", [[0, 0, 1, 1], [1, 1, 0, 0]])
def test_load_arrow_is_at_the_loaded_end_of_the_beam(monkeypatch, order):
    """Poses are computed in two parts, whose loads act at different ends."""
    monkeypatch.setattr(arrays, "AT_ONCE", 2)
    one = robot("2pru_upr")
    at = one.assemble(platform={"z": [0.55, 0.6, 0.62, 0.65], "rx": 0.05, "ry": -0.1})
    frame, points = at.frame("rod_1")[0], ks.analyze(at).beams["rod_1"].points[0]
    ends = np.array([frame[:3, :3].T @ (point - frame[:3, 3]) for point in points[[0, -1]]])
    found = ks.analyze(at, loads={"rod_1": ks.LinkLoad([3.0, 4, 12, 0, 0, 0], ends[order])})
    arrows = [arrow for arrow in describe_scene(found).arrows if arrow.group == "external load" and "rod_1" in arrow.name]
    np.testing.assert_allclose(sum(arrow.vector for arrow in arrows).sum(axis=1), [[3, 4, 12]] * 4)


@pytest.mark.parametrize(("name", "link"), [("3rps", None), ("2pru_upr", "slider"), ("ur10", None)])
def test_payload_coefficients_are_differences_of_two_analyses(name, link):
    at = pose(name)
    if link is not None:
        link = rigid_links(at.robot)[0]
    first = ks.analyze(at, payload=ks.Payload(2.0, (0.1, -0.2, 0.05), link=link))
    second = ks.analyze(at, payload=ks.Payload(9.0, (-0.3, 0.1, 0.2), link=link))
    change = np.array([9.0, -2.7, 0.9, 1.8]) - np.array([2.0, 0.2, -0.4, 0.1])
    found = first.payload_coefficients
    assert found.parameters == ("mass", "first_moment_x", "first_moment_y", "first_moment_z")
    assert found.twist.shape == (6, 4)
    close(found.twist @ change, second.twist - first.twist, 1e-9)
    for drive, force in first.actuator_forces.items():
        assert float(found.actuator_forces[drive] @ change) == pytest.approx(
            float(second.actuator_forces[drive] - force), rel=1e-9, abs=1e-9
        )
    for joint, wrench in first.joint_wrenches.items():
        np.testing.assert_allclose(found.joint_wrenches[joint] @ change, second.joint_wrenches[joint] - wrench, atol=1e-9)
    close(found.twist @ [2.0, 0.2, -0.4, 0.1], first.contributions["payload"], 1e-9)


def test_payload_coefficients_default_to_the_platform():
    at = pose("3rps")
    assert np.array_equal(
        ks.analyze(at).payload_coefficients.twist, ks.analyze(at, payload=ks.Payload(3.0)).payload_coefficients.twist
    )


def test_load_that_passive_joints_cannot_hold_raises_an_error():
    """A strut between two spherical joints spins about itself."""
    one = small_robots.robot_of(small_robots.gough("S"))
    at = one.configuration(one.model_q(one.generic_poses)[:, 0], closure_tolerance=1e-9)
    beam = next(iter(ks.analyze(at).beams.values()))
    frame, link = at.frame(beam.description.link), beam.description.link
    end, axis = frame[:3, :3].T @ (beam.points[-1] - frame[:3, 3]), beam.axes[:, 0]
    held = ks.analyze(at, loads={link: ks.LinkLoad([*axis, 0, 0, 0], end)})
    assert held.status == ks.Status.OK
    with pytest.raises(
        ks.exceptions.LimbEquilibriumError, match=r"and the loads on its links: its passive joints .* of these is not carried"
    ):
        ks.analyze(at, loads={link: ks.LinkLoad([0, 0, 0, *axis], end)})


def test_loads_on_links_within_a_compound_joint_are_refused():
    with pytest.raises(ks.ArgumentError, match="'cross_1' has no mass and lies between the joints universal_1_x, universal_1_y"):
        ks.analyze(pose("2pru_upr"), loads={"cross_1": [0, 0, 0, 1, 0, 0]})
    # rigid links welded to one another between hinges whose axes meet
    description = robot("spherical_3rrr").description
    rigid = ks.Robot(replace(description, beams={})).assemble()
    with pytest.raises(ks.ArgumentError, match="'distal_1_2' has no mass and lies between the joints elbow_1, tip_1"):
        ks.analyze(rigid, loads={"distal_1_2": [1, 2, 3, 0, 0, 0]})
    held = sm.robot(
        sm.link("base"), sm.link("inner"), sm.link("outer"), sm.link("platform", 3.0), sm.link("column"),
        sm.joint("first", "continuous", "base", "inner", axis="1 0 0"), sm.joint("weld", "fixed", "inner", "outer"),
        sm.joint("second", "continuous", "outer", "platform"), sm.joint("foot", "fixed", "base", "column", "0.3 0 0"),
        sm.loop("top", "fixed", "column", "platform", "0 0 0.5", "0.3 0 0.5"),
        sm.bar("column", "foot", "top", sm.RHO, sm.CIRCLE),
    )  # fmt: skip
    for name in ("inner", "outer"):
        with pytest.raises(ks.ArgumentError, match=f"'{name}' has no mass and lies between the joints first, second"):
            ks.analyze(held.assemble(), loads={name: [1, 2, 3, 0, 0, 0]})


@pytest.mark.few(1)
@pytest.mark.parametrize("elastic", [("lower_1", "lower_2", "lower_3"), ("upper_2", "lower_2", "upper_3", "lower_3")])
def test_a_massless_link_between_parallel_hinges_may_be_loaded(elastic):
    """Actuator forces by virtual work of the load as the actuators move; the rest agrees with finite elements."""
    whole = robot("tripteron").description
    one = ks.Robot(replace(whole, beams={name: whole.beams[name] for name in elastic}))
    at = {name: value + 0.03 * k for k, (name, value) in enumerate(one.assemble().actuators.items(), 1)}
    load, here = ks.LinkLoad([30, -20, 50, 3, -2, 4], (0.1, 0.02, -0.03)), one.assemble(actuators=at)
    found = ks.analyze(here, gravity=NO_GRAVITY, loads={"upper_1": load}).actuator_forces
    arm = here.frame("upper_1")[:3, :3] @ load.point
    for name, moved in zip(at, rates(one, at, lambda pose: pose.frame("upper_1")).T, strict=True):
        work = load.wrench @ np.concatenate([moved[:3] + np.cross(moved[3:], arm), moved[3:]])
        assert found[name] == pytest.approx(-work, rel=1e-6, abs=1e-6)
    assert max(ks.verify(here, loads={"upper_1": load}).differences.values()) < 1e-8


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--payload 5N", "'5N' is a force, but a mass is needed"),
        ("--payload-center 0 0 1", "--payload-center gives the position of a payload, but its mass is missing"),
        ("--load-on rod_1 0 0 1", "--load-on rod_1: there are 3 numbers; give FX FY FZ MX MY MZ"),
        ("--load-on rod_7 0 0 1 0 0 0", "loads= names no link 'rod_7': did you mean 'rod_3' or 'rod_2' or 'rod_1'?"),
    ],
)
def test_command_line_reports_wrong_load_options(options, words, capsys):
    assert main(["analyze", "3rps", *options.split()]) == 2
    assert words in capsys.readouterr().err
