"""The robot files open unchanged in Pinocchio and yourdfpy, and their zero configuration is the paper's first."""

import io
import math
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import xacro
import yourdfpy
from places import ROBOTS

import kinetostatics as ks
from kinetostatics.files.reader import parameter_values

NAMES = ("3rps", "2pru_upr")

pytestmark = pytest.mark.parametrize("name", NAMES)


@cache
def expand(name: str) -> str:
    return xacro.process_file(str(ROBOTS / f"{name}.urdf.xacro")).toxml()


def link_frames(xml: str) -> dict[str, pin.SE3]:
    """Every link's frame in the world at the zero configuration."""
    model = pin.buildModelFromXML(xml)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return {frame.name: data.oMf[i] for i, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}


def test_opens_in_yourdfpy(name, capfd, caplog):
    robot = yourdfpy.URDF.load(io.BytesIO(expand(name).encode()))
    assert robot.base_link == "base"
    assert robot.validate()
    assert len(robot.scene.geometry) > 20
    height = robot.get_transform("platform", "base")[2, 3]
    assert height == pytest.approx({"3rps": math.sqrt(0.55**2 - 0.1**2), "2pru_upr": 0.6}[name], abs=1e-12)
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""
    assert not caplog.records


def test_mass_and_inertia_are_the_platforms(name):
    model = pin.buildModelFromXML(expand(name))
    platform = model.inertias[model.frames[model.getFrameId("platform")].parentJoint]
    placement = model.frames[model.getFrameId("platform")].placement
    own = placement.actInv(platform)
    if name == "3rps":
        mass = math.pi * 0.2**2 * 0.02 * 7820
        center = np.zeros(3)
        moments = mass * np.array([(3 * 0.2**2 + 0.02**2) / 12, (3 * 0.2**2 + 0.02**2) / 12, 0.2**2 / 2])
    else:
        mass = 0.25**2 * 0.05 * 7850
        vertices = np.array([[0, 0.25, 0], [0, -0.25, 0], [0.25, 0, 0]])
        center = vertices.mean(axis=0)
        x, y = np.mean((vertices - center) ** 2, axis=0)[:2] / 4  # a triangle's own second moments
        z = 0.05**2 / 12
        moments = mass * np.array([y + z, x + z, x + y])
    assert pin.computeTotalMass(model) == pytest.approx(mass, rel=1e-14)
    assert own.mass == pytest.approx(mass, rel=1e-14)
    np.testing.assert_allclose(own.lever, center, atol=1e-14)
    np.testing.assert_allclose(own.inertia, np.diag(moments), atol=1e-14)


def test_zero_configuration_is_the_papers_first(name):
    at = {link: frame.translation for link, frame in link_frames(expand(name)).items()}
    platform = link_frames(expand(name))["platform"]
    np.testing.assert_allclose(platform.rotation, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(platform.translation[:2], 0, atol=1e-14)
    if name == "3rps":
        for number, azimuth in enumerate(np.radians([0, -120, 120]), start=1):
            base, top = at[f"cylinder_{number}"], at[f"rod_{number}"]
            direction = np.array([math.cos(azimuth), math.sin(azimuth), 0])
            np.testing.assert_allclose(base, 0.3 * direction, atol=1e-14)
            np.testing.assert_allclose(top, 0.2 * direction + platform.translation, atol=1e-14)
            assert np.linalg.norm(top - base) == pytest.approx(0.55, abs=1e-14)
    else:
        reach = 0.25 + math.sqrt(0.7**2 - 0.6**2)
        np.testing.assert_allclose(at["slider_1"], [0, reach, 0], atol=1e-14)
        np.testing.assert_allclose(at["slider_2"], [0, -reach, 0], atol=1e-14)
        np.testing.assert_allclose(at["cross_1"], [0, 0.25, 0.6], atol=1e-14)
        np.testing.assert_allclose(at["cross_3"], [0.5, 0, 0], atol=1e-14)
        np.testing.assert_allclose(at["rod_3"], [0.25, 0, 0.6], atol=1e-14)


@pytest.mark.few(1)
def test_every_argument_has_an_effect_and_the_loops_close_at_zero(name):
    values = parameter_values(name, {})
    default = ks.load_robot(name)
    for argument, text in values.items():
        changed = ks.load_robot(name, {argument: 1.02 * float(text)})
        assert changed.description.urdf != default.description.urdf, argument
    robot = ks.load_robot(name, {argument: 1.02 * float(text) for argument, text in values.items()})
    robot.configuration(pin.neutral(robot.model), closure_tolerance=1e-12)
