"""A beam as a link given by its stiffness and mass matrices gives the results of the beam: as ``<flexible>``, and by a class of
these tests."""

from dataclasses import replace

import numpy as np
import pytest
from hybrid_robots import random_hybrid, write_randomly
from matrix_link import MatrixLink, with_flexible, with_matrix_links
from simple_machines import CIRCLE, bar, joint, link, springs
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.description.elements import BeamEnd, Inertia
from kinetostatics.math.rotations import skew
from kinetostatics.workspace.sweep_plan import text_digest

LOAD, GRAVITY = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81)
ROBOTS = ["linear_delta", *range(60)]


def _robot(which):
    if isinstance(which, str):
        return ks.load_robot(which)
    return write_randomly(random_hybrid(which), which)[1].robot()


def _alike(found, expected, name=""):
    if hasattr(expected, "items"):
        assert list(found) == list(expected)
        for key, value in expected.items():
            _alike(found[key], value, f"{name}/{key}")
    else:
        scale = np.max(np.abs(np.nan_to_num(expected)), initial=0.0)
        assert np.allclose(found, expected, rtol=0, atol=1e-9 * scale, equal_nan=True), name


def _result(robot, assembly_errors=None):
    try:
        return ks.analyze(robot.assemble(), load=LOAD, gravity=GRAVITY, assembly_errors=assembly_errors)
    except ks.KinetostaticsError as error:
        return str(error)


@pytest.mark.few(6)
@pytest.mark.parametrize("which", ROBOTS)
@pytest.mark.parametrize("with_links", [with_matrix_links, with_flexible])
def test_statics(which, with_links, request):
    if (which, with_links) == (22, with_flexible):
        request.applymarker(pytest.mark.xfail(strict=True, reason="the error names the passive joints in another order"))
    robot = _robot(which)
    links = {name: beam.span.part.link for name, beam in robot.beams.items() if not beam.telescopic}
    expected, half = _result(robot), list(dict.fromkeys(links.values()))[::2]  # beams of one link share its mass
    for some in (list(links), [name for name in links if links[name] in half]):
        found = _result(with_links(robot, some))
        if isinstance(expected, str):
            assert found == expected
            return
        for name in ("twist", "compliance", "actuator_forces", "joint_wrenches", "contributions", "base_wrench"):
            _alike(getattr(found, name), getattr(expected, name), name)


def _pair(which="linear_delta"):
    robot = _robot(which)
    return with_matrix_links(robot), robot


@pytest.mark.parametrize("which", ["linear_delta", 1, 2, 3, 8])
def test_assembly_errors(which):
    first, second = _pair(which)
    errors = {link: {"length": 1e-4 * (k + 1)} for k, link in enumerate(second.description.beams)}
    found, expected = (_result(robot, errors) for robot in (first, second))
    for name in ("twist", "joint_wrenches", "contributions"):
        _alike(getattr(found, name), getattr(expected, name), name)


def test_sensitivities():
    """A factor of the stiffness acts as both moduli of the beam; numbers of other parts act as in the robot with beams."""
    names, outputs = ["rod_1.factor", "rod_1.youngs_modulus", "rod_1.shear_modulus"], ["twist", "stiffness", "actuator_forces"]
    options = {"outputs": outputs, "load": LOAD, "gravity": GRAVITY}
    first, second = (
        ks.sensitivities(robot.assemble(), by=[*by, "platform.mass", "rail_*.placement.x"], **options)
        for robot, by in zip(_pair(), (names[:1], names[1:]), strict=True)
    )
    assert len(first) > 2
    moduli = [second[name] for name in names[1:]]
    for output in outputs:
        for name in first:
            if name == names[0]:
                if output != "actuator_forces":  # their derivatives are zero
                    _alike(first[name].derivatives[output], sum(item.value * item.derivatives[output] for item in moduli), output)
            else:
                _alike(first[name].derivatives[output], second[name].derivatives[output], f"{name} {output}")
    _alike(first.sources, second.sources)


@pytest.mark.parametrize("which", ["linear_delta", 1])
def test_compiled(which):
    pairs = _pair(which)
    results = [ks.analyze(robot.assemble(), load=LOAD, gravity=GRAVITY, engine="compiled") for robot in pairs]
    for name in ("twist", "compliance", "actuator_forces", "joint_wrenches", "contributions"):
        _alike(getattr(results[0], name), getattr(results[1], name), name)


def test_function():
    results = []
    for robot in _pair():
        function = ks.compile(robot, ("x", "y", "z"), outputs=["twist", "actuator_forces"])
        at = {name: float(robot.assemble().platform[name]) for name in ("x", "y", "z")}
        results.append((dict(function(**at, load=LOAD)), dict(function.jacobian("twist", by=("x", "load"))(**at, load=LOAD))))
    for found, expected in zip(*results, strict=True):
        _alike(found, expected)


def test_map():
    first, second = (_map(robot) for robot in _pair())
    assert set(second) - set(first) <= {"stress", "euler_ratio"}
    for name in first:
        if first[name].dtype.kind == "f":
            _alike(first[name].values, second[name].values, name)


def _map(robot):
    zero = robot.assemble().platform
    grid = {name: float(zero[name]) + np.linspace(-0.05, 0.05, 4) for name in ("x", "y", "z")}
    return ks.sweep(robot, platform=grid, load=LOAD, gravity=GRAVITY)


@pytest.mark.parametrize("which", ["ur10", 2, 3, 8])
def test_modes(which):
    """Under a heavy platform, whose modes are far below those of the links, their mass matrices are exact to 1e-9."""
    robot = _robot(which)
    heavy = Inertia((1e6, 0.0, 0.0, 1e6, 0.0, 1e6))
    robot = ks.Robot(robot.description.with_payload("weight", robot.description.platform, 1e6, inertia=heavy))
    links = {name: replace(beam, material=replace(beam.material, density=0.0)) for name, beam in robot.description.beams.items()}
    first, second, without_mass = (
        ks.modes(item.assemble(), 6)
        for item in (with_matrix_links(robot), robot, ks.Robot(replace(robot.description, beams=links)))
    )
    assert np.abs(first.frequencies / second.frequencies - 1).max() < 1e-9
    assert np.abs(without_mass.frequencies / second.frequencies - 1).min() > 1e-8


LINEAR, ANGULAR = (4e6, 3e6, 9e6), (8e3, 5e3, 2e4)


def _arm(*, jointed):
    """Return an arm of a soft link and a beam; the soft link is rigid with an elastic joint at its end, or given by matrices."""
    rows = {key: " ".join(map(str, value)) for key, value in (("linear", LINEAR), ("angular", ANGULAR))}
    tip = [link("tip"), joint("flex", "fixed", "upper", "tip", "0.4 0 0"), springs("flex", **rows)] if jointed else []
    parts = [link("base"), link("upper", 20.0, "0.2 0.05 0.1"), link("fore", 1.0, "0.15 0 0"), link("platform", 0.5)]
    parts += [joint("shoulder", "revolute", "base", "upper"), *tip]
    parts += [joint("elbow", "revolute", "tip" if jointed else "upper", "fore", "0 0 0" if jointed else "0.4 0 0", "0 0 1")]
    parts += [joint("wrist", "fixed", "fore", "platform", "0.3 0 0"), bar("fore", "elbow", "wrist", 7850.0, CIRCLE)]
    parts += [f'<transmission name="t_{name}"><joint name="{name}"/></transmission>' for name in ("shoulder", "elbow")]
    stay = '<predecessor link="base"><origin xyz="0.1 0 1"/></predecessor><successor link="platform"/>'
    parts += [f'<spring name="stay" stiffness="900" free_length="0.1">{stay}</spring>']
    machine = robot_of(*parts)
    if jointed:
        return machine
    K, M = np.zeros((12, 12)), np.zeros((12, 12))
    back = np.eye(6)
    back[:3, 3:] = -skew(np.array([0.4, 0.0, 0.0]))
    ends = np.hstack([-back, np.eye(6)])
    K[:] = ends.T @ np.diag([*LINEAR, *ANGULAR]) @ ends
    own = machine.description.links["upper"]
    arm = skew(np.array(own.center_of_mass))
    M[:6, :6] = np.block([[own.mass * np.eye(3), -own.mass * arm], [own.mass * arm, own.inertia.matrix - own.mass * arm @ arm]])
    soft = MatrixLink.of("upper", BeamEnd("shoulder"), BeamEnd("elbow"), K, M)
    return ks.Robot(replace(machine.description, flexible={"upper": soft}))


def test_soft_end():
    """A rigid link with an elastic joint at its end, as matrices, gives the same results, also those of second order."""
    first, second = (_arm(jointed=jointed).assemble(actuators={"shoulder": -0.9, "elbow": 0.3}) for jointed in (False, True))
    for spring in (True, False):
        if not spring:
            first, second = (
                ks.Robot(replace(pose.robot.description, springs={})).assemble(actuators=dict(pose.actuators))
                for pose in (first, second)
            )
        found, expected = (ks.analyze(pose, load=LOAD, gravity=GRAVITY) for pose in (first, second))
        for name in ("twist", "compliance", "actuator_forces", "contributions", "strain_energy"):
            _alike(getattr(found, name), getattr(expected, name), name)
        _alike(ks.modes(first, 4).frequencies, ks.modes(second, 4).frequencies)
        _alike(found.buckling(3).load_factors, expected.buckling(3).load_factors)
        _alike(found.beams["fore"].euler_ratio, expected.beams["fore"].euler_ratio)
    _alike(found.second_order.twist, expected.second_order.twist)
    _alike(found.second_order.compliance, expected.second_order.compliance)


def test_everything_else(tmp_path):
    """Reports, scene and warnings know the links; what cannot know them says so."""
    machine = ks.load_robot("linear_delta")
    machine = with_matrix_links(machine, ["rod_1", "rod_2"])
    pose = machine.assemble()
    result = ks.analyze(pose, load=LOAD)
    assert "rod_1" in str(result.report())
    assert list(result.beams) == ["rod_3"]
    assert set(result.source_contributions["links"]) == {"rod_1", "rod_2"}
    assert not machine.warnings
    assert "without mass" not in str(machine.report())
    for what in (result, ks.modes(pose, 2), pose, machine):
        ks.save_html(what, tmp_path / "scene.html")
    ks.save_report(pose, tmp_path / "report.html")
    assert "verify cannot check rod_1 and rod_2" in (tmp_path / "report.html").read_text()
    with pytest.raises(ks.ArgumentError, match="verify cannot check rod_1 and rod_2"):
        ks.verify(pose)
    with pytest.raises(ks.RobotFileError, match="'rod_1' is no beam, and files have no element for it"):
        ks.save_robot(machine, tmp_path / "robot.urdf")
    with pytest.raises(ks.StaticsError, match="inertial load of the elastic link 'rod_1' is unknown"):
        ks.analyze(pose, motion=ks.Motion(accelerations={"x": 1.0, "y": 0.0, "z": 0.0}))
    softer = ks.Robot(machine.description.changed("rod_1", factor=0.5))
    assert np.abs(ks.analyze(softer.assemble(), load=LOAD).twist / result.twist - 1).max() > 0.01
    assert text_digest(softer.description) != text_digest(machine.description)
