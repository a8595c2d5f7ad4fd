"""The robot files open unchanged in Pinocchio and yourdfpy, and their zero configuration is the paper's first."""

import io
import math
import xml.etree.ElementTree as ET
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import xacro
import yourdfpy
from places import ROBOTS

import kinetostatics as ks

NAMES = ("3rps", "2pru_upr")

pytestmark = pytest.mark.parametrize("name", NAMES)


@cache
def expand(name: str, **values: object) -> str:
    mappings = {key: str(value) for key, value in values.items()}
    return xacro.process_file(str(ROBOTS / f"{name}.urdf.xacro"), mappings=mappings).toxml()


def vector(element: ET.Element | None, key: str, default: str = "0 0 0") -> np.ndarray:
    text = default if element is None else element.get(key, default)
    return np.array([float(part) for part in text.split()])


def side(loop: ET.Element, which: str, links: dict[str, pin.SE3]) -> pin.SE3:
    """The origin frame of a loop's predecessor or successor in the world."""
    element = loop.find(which)
    origin = element.find("origin")
    rotation = pin.rpy.rpyToMatrix(vector(origin, "rpy"))
    return links[element.get("link")] * pin.SE3(rotation, vector(origin, "xyz"))


def link_frames(xml: str) -> dict[str, pin.SE3]:
    """Every link's frame in the world at the zero configuration."""
    model = pin.buildModelFromXML(xml)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return {frame.name: data.oMf[i] for i, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}


def closure_errors(xml: str) -> dict[str, float]:
    """By how much each loop stays open at the zero configuration [m or rad]."""
    links = link_frames(xml)
    errors = {}
    for loop in ET.fromstring(xml).findall("loop"):
        relative = side(loop, "predecessor", links).actInv(side(loop, "successor", links))
        gaps = [np.abs(relative.translation).max()]
        axis = vector(loop.find("axis"), "xyz", "1 0 0")
        if loop.get("type") == "revolute":
            gaps.append(np.abs(relative.rotation @ axis - axis).max())
        elif loop.get("type") == "universal":
            gaps.append(abs(axis @ relative.rotation @ vector(loop.find("axis2"), "xyz", "0 1 0")))
        else:
            assert loop.get("type") == "spherical"
        errors[loop.get("name")] = max(gaps)
    return errors


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


def test_zero_configuration_closes_the_loops(name):
    errors = closure_errors(expand(name))
    assert set(errors) == {"3rps": {"spherical_1", "spherical_2", "spherical_3"}, "2pru_upr": {"universal_2", "revolute_3"}}[name]
    assert max(errors.values()) < 1e-12


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


CHANGES = {
    "3rps": {
        "base_radius": 0.4,
        "platform_radius": 0.15,
        "home_length": 0.6,
        "rod_length_min": 0.3,
        "rod_length_max": 0.9,
        "joint_angle_max": 0.8,
        "rod_diameter": 0.05,
        "youngs_modulus": 70e9,
        "poisson_ratio": 0.33,
        "density": 2700,
        "shear_coefficient": 0.9,
        "platform_thickness": 0.01,
        "platform_mass": 5,
    },
    "2pru_upr": {
        "platform_radius": 0.2,
        "base_radius": 0.45,
        "rod_length": 0.75,
        "home_height": 0.5,
        "slider_min": 0.3,
        "slider_max": 1.2,
        "telescope_min": 0.2,
        "telescope_max": 0.9,
        "joint_angle_max": 0.8,
        "rod_diameter": 0.05,
        "youngs_modulus": 70e9,
        "poisson_ratio": 0.33,
        "density": 2700,
        "shear_coefficient": 0.9,
        "platform_thickness": 0.03,
        "platform_mass": 5,
    },
}


@pytest.mark.few(1)
def test_every_argument_is_listed_and_has_an_effect(name):
    source = ET.parse(ROBOTS / f"{name}.urdf.xacro").getroot()
    tag = "{http://www.ros.org/wiki/xacro}arg"
    assert {element.get("name") for element in source.findall(tag)} == set(CHANGES[name])
    default = expand(name)
    for argument, value in CHANGES[name].items():
        changed = expand(name, **{argument: value})
        assert changed != default, argument
        pin.buildModelFromXML(changed)
        assert max(closure_errors(changed).values()) < 1e-12, argument


def test_what_is_saved_opens_as_the_same(name, tmp_path, capfd, caplog):
    """Other tools see in a saved file what they see in the xacro: masses, inertias, limits, frames, shapes and colours."""
    xml = expand(name)
    ks.save_robot(ks.load_robot(ROBOTS / f"{name}.urdf.xacro"), tmp_path / "saved.urdf")
    saved = (tmp_path / "saved.urdf").read_text(encoding="utf-8")
    one, other = pin.buildModelFromXML(xml), pin.buildModelFromXML(saved)
    assert list(other.names) == list(one.names) and [frame.name for frame in other.frames] == [frame.name for frame in one.frames]
    for attribute in ("lowerPositionLimit", "upperPositionLimit", "effortLimit", "velocityLimit"):
        np.testing.assert_array_equal(getattr(other, attribute), getattr(one, attribute))
    for first, second in zip(one.inertias, other.inertias, strict=True):
        np.testing.assert_array_equal(second.toDynamicParameters(), first.toDynamicParameters())
    for first, second in zip(one.jointPlacements, other.jointPlacements, strict=True):
        np.testing.assert_array_equal(second.homogeneous, first.homogeneous)
    shapes = [pin.buildGeomFromUrdfString(m, x, pin.GeometryType.VISUAL).geometryObjects for m, x in ((one, xml), (other, saved))]
    assert [(shape.name, shape.parentJoint) for shape in shapes[1]] == [(shape.name, shape.parentJoint) for shape in shapes[0]]
    for first, second in zip(*shapes, strict=True):
        np.testing.assert_array_equal(second.placement.homogeneous, first.placement.homogeneous)
        np.testing.assert_array_equal(second.meshColor, first.meshColor)
    drawn = [yourdfpy.URDF.load(io.BytesIO(text.encode())) for text in (xml, saved)]
    assert drawn[1].validate() and len(drawn[1].scene.geometry) == len(drawn[0].scene.geometry)
    printed = capfd.readouterr()
    assert printed.out == printed.err == "" and not caplog.records
