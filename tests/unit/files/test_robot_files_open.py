"""The robot files of the paper open unchanged in Pinocchio and yourdfpy; masses, inertias and arguments."""

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


def test_robot_file_opens_in_yourdfpy(name, capfd, caplog):
    robot = yourdfpy.URDF.load(io.BytesIO(expand(name).encode()))
    assert robot.base_link == "base"
    assert robot.validate()
    assert len(robot.scene.geometry) > 20
    height = robot.get_transform("platform", "base")[2, 3]
    assert height == pytest.approx({"3rps": math.sqrt(0.55**2 - 0.1**2), "2pru_upr": 0.6}[name], abs=1e-12)
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""
    assert not caplog.records


def test_platform_mass_and_inertia_equal_closed_forms(name):
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


@pytest.mark.few(1)
def test_every_argument_has_an_effect_and_loops_close(name):
    values = parameter_values(name, {})
    default = ks.load_robot(name)
    for argument, text in values.items():
        changed = ks.load_robot(name, {argument: 1.02 * float(text)})
        assert changed.description.urdf != default.description.urdf, argument
    robot = ks.load_robot(name, {argument: 1.02 * float(text) for argument, text in values.items()})
    robot.configuration(pin.neutral(robot.model), closure_tolerance=1e-12)
