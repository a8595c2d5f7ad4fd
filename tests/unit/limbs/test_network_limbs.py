"""Limbs that are networks: intensities are labelled as components; reports and arrows show forces of beams and joints."""

import re

import numpy as np
import package_robots
import pytest

import kinetostatics as ks
from kinetostatics.viewer.scene import describe_scene

PAR4 = "tests/cases/par4_articulated.urdf.xacro"
LOAD = [20, -30, -100, 1, 2, 3]
NETWORKS = (PAR4, "robots/delta.urdf.xacro", "robots/orthoglide.urdf.xacro")
FORCES = {"joints of networks", "axial forces in networks"}
COMPONENTS = {"constraint forces", "constraint couples", "attached wrenches"}


@pytest.fixture(autouse=True)
def in_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


@pytest.fixture(scope="module", params=NETWORKS)
def result(request):
    robot = ks.load_robot(request.config.rootpath / request.param)
    return ks.analyze(robot.assemble(actuators=dict.fromkeys(robot.description.actuated, 0.01)), load=LOAD)


@pytest.mark.few(1)
def test_network_labels_name_components_beams_and_platform_joints(result):
    plain = result.to_dict()["limbs"]
    for name, limb in result.limbs.items():
        assert limb.is_network and plain[name]["is_network"] is True
        assert plain[name]["beams"] == list(limb.beams) and plain[name]["platform_joints"] == list(limb.platform_joints)
        for label in (*limb.labels, *limb.attached_labels):
            assert label.startswith(("force component ", "couple component ", "complementary wrench"))
    report = " ".join(str(result.robot).split())
    assert "Components are coordinates, in a basis, of the wrench of a limb that is a network" in report


def test_serial_limbs_have_no_components():
    result = ks.analyze(package_robots.robot("2pru_upr").assemble())
    for limb in result.limbs.values():
        assert not limb.is_network and not any("component" in label for label in (*limb.labels, *limb.attached_labels))
    assert not FORCES & {arrow.group for arrow in describe_scene(result).arrows}


def test_rods_of_parallelograms_share_the_load_equally():
    """100 N hang on four pairs of rods: each rod carries about an eighth of the weight over the cosine of its slope."""
    result = ks.analyze(ks.load_robot(PAR4).assemble(), load=[0, 0, -100, 0, 0, 0])
    report = str(result.report())
    table = report[report.index("Limbs that are networks") : report.index("\n\nJoints:")]
    shown = dict(re.findall(r"(rod_\w\w) +axial force at the platform end +([-\d.]+)", table))
    assert len(shown) == 8
    down = -float(result.configuration.frame("plate_A")[2, 3] - result.configuration.frame("wrist_1")[2, 3])
    hanging = 100 + 9.81 * (2 + 0.3 + 0.3 + 0.2 + 0.1296)  # payload, plates, bars
    for name, force in shown.items():
        assert float(force) == pytest.approx(result.beams[name].section_wrenches[-1, 0], abs=6e-4)
        assert float(force) == pytest.approx(hanging / 8 / (down / 0.825), rel=0.06)
    assert "limb_1 is a network: its components are coordinates in a basis, not forces in beams or joints" in report
    limbs = report[report.index("\nLimbs:") : report.index("\nLimbs that are")]
    assert not re.search(r"force along (rod|arm|bar)", report) and "force component on the line of rod_3a" in limbs


@pytest.mark.few(1)
def test_arrows_of_networks_are_forces_in_joints_and_beams(result):
    scene = describe_scene(result)
    assert not COMPONENTS & {arrow.group for arrow in scene.arrows}
    o = scene.stations.rest[scene.readout][0, :3, 3]
    for limb in result.limbs.values():
        total = np.zeros(6)
        for arrow in scene.arrows:
            if arrow.group == "joints of networks" and arrow.name.startswith(f"{limb.name}: "):
                vector = arrow.vector[0].sum(axis=0)
                if arrow.kind == "force":
                    total[:3] += vector
                    total[3:] += np.cross(scene.stations.rest[arrow.station][0, :3, 3] - o, vector)
                else:
                    total[3:] += vector
        np.testing.assert_allclose(total, limb.wrench, rtol=1e-9, atol=1e-9 * np.abs(limb.wrench).max())
        axial = {arrow.name: arrow for arrow in scene.arrows if arrow.group == "axial forces in networks"}
        for name in limb.beams:
            arrow, beam = axial[f"{limb.name}: {name}"], result.beams[name]
            force = beam.section_wrenches[-1, 0] * beam.axes[:, 0]
            np.testing.assert_allclose(arrow.vector[0].sum(axis=0), force, atol=1e-9 * np.abs(limb.wrench).max())
            np.testing.assert_array_equal(arrow.positive[0], beam.axes[:, 0])
            np.testing.assert_allclose(scene.stations.rest[arrow.station][0, :3, 3], beam.points[-1])
            np.testing.assert_allclose(
                scene.stations.twists[arrow.station][0].sum(axis=0)[:3], beam.deflections[-1], atol=1e-15, rtol=1e-9
            )
