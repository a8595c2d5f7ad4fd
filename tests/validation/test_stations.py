"""Beams whose section varies: closed forms of tapered cantilevers, and robots with uniform beams welded one after the other."""

from dataclasses import replace

import numpy as np
import pytest
from hybrid_robots import random_hybrid, write_randomly
from scipy.integrate import quad
from scipy.optimize import brentq
from simple_machines import joint, link
from simple_machines import robot as robot_of

import kinetostatics as ks
from kinetostatics.elements import profile
from kinetostatics.sections import Station, Tapered

E, NU, RHO, L = 70e9, 0.3, 2700.0, 0.8
G = E / 2 / (1 + NU)
LOAD, GRAVITY = [10.0, -20.0, -300.0, 4.0, 5.0, 6.0], (0.5, 0.3, -9.81)
MATERIAL = f'youngs_modulus="{E}" poisson_ratio="{NU}" density="{RHO}" y_axis="0 1 0"'


def beam(name, *stations, more=""):
    """A beam with stations (place, section element, offset)."""
    elements = "".join(f'<station at="{at}" offset="{offset}">{section}</station>' for at, section, offset in stations)
    return f'<beam link="{name}" {MATERIAL} {more}>{elements}</beam>'


def circle(diameter):
    return f'<circle diameter="{diameter!r}"/>'


def rectangle(width, height):
    return f'<rectangle width="{width!r}" height="{height!r}"/>'


def arm(*stations, more="", length=L, mass=0.0):
    """A cantilever along x."""
    every = [(*station, "0 0") if len(station) == 2 else station for station in stations]
    parts = [link("base"), link("arm"), link("platform", mass), joint("wall", "fixed", "base", "arm")]
    return robot_of(*parts, joint("tip", "fixed", "arm", "platform", f"{length} 0 0"), beam("arm", *every, more=more))


def cone(first=0.05, last=0.02, more='shear_coefficient="inf"', **kwargs):
    return arm((0, circle(first)), (1, circle(last)), more=more, **kwargs)


def chain(pieces, mass=0.0, times=1):
    """A cantilever of uniform beams (length, section element, offset), each in equal parts, welded to rigid faces."""
    pieces = [(length / times, *rest) for length, *rest in pieces for _ in range(times)]
    parts, before, offset = [link("base"), link("platform", mass)], "base", np.zeros(2)
    for k, (length, section, beside) in enumerate(pieces):
        y, z = beside - offset
        parts += [link(f"piece_{k}"), joint(f"start_{k}", "fixed", before, f"piece_{k}", f"0 {y} {z}")]
        parts += [link(f"face_{k}"), joint(f"end_{k}", "fixed", f"piece_{k}", f"face_{k}", f"{length} 0 0")]
        parts.append(f'<beam link="piece_{k}" from="start_{k}" to="end_{k}" {MATERIAL}>{section}</beam>')
        before, offset = f"face_{k}", np.array(beside)
    return robot_of(*parts, joint("tip", "fixed", before, "platform", f"0 {-offset[0]} {-offset[1]}"))


def analyzed(robot, load=LOAD, gravity=GRAVITY, **more):
    return ks.analyze(robot.assemble(), load=load, gravity=gravity, **more)


def alike(result, expected, within=1e-9, name=""):
    if hasattr(expected, "items"):
        assert list(result) == list(expected)
        for key, value in expected.items():
            alike(result[key], value, within, f"{name}/{key}")
    else:
        scale = np.max(np.abs(np.nan_to_num(expected)), initial=0.0)
        assert np.allclose(result, expected, rtol=0, atol=within * scale, equal_nan=True), name


# ---- closed forms of tapered cantilevers


@pytest.mark.parametrize("last", [0.05, 0.02, 0.002])
def test_compliance_of_a_cone(last):
    """Deflection 64 P L³ / 3π E a³ b of a cone with end diameters a and b, and the closed forms of its other compliances."""
    first = 0.05
    robot = cone(first, last)
    C = analyzed(robot, load=np.zeros(6), gravity=(0, 0, 0)).compliance
    assert C[0, 0] == pytest.approx(4 * L / (np.pi * E * first * last), rel=1e-10)
    assert C[2, 2] == pytest.approx(64 * L**3 / (3 * np.pi * E * first**3 * last), rel=1e-10)
    turned = 64 * L * (first**2 + first * last + last**2) / (3 * np.pi * E * first**3 * last**3)
    assert C[4, 4] == pytest.approx(turned, rel=1e-10)
    assert C[3, 3] == pytest.approx(turned / 2 * E / G, rel=1e-10)
    slope = 64 / (np.pi * E) * quad(lambda x: x / (last + (first - last) * x / L) ** 4, 0, L, epsabs=0, epsrel=1e-12)[0]
    assert C[2, 4] == pytest.approx(-slope, rel=1e-10)


def test_shear_and_own_weight():
    """Deflections of a cantilever whose depth varies by twice integrating curvature and shear, by quadrature."""
    width, first, last = 0.03, 0.06, 0.03
    robot = arm((0, rectangle(width, first)), (1, rectangle(width, last)))

    def height(x):
        return first + (last - first) * x / L

    kappa, g = 10 * (1 + NU) / (12 + 11 * NU), 9.81

    def force(x):
        return -RHO * g * width * quad(height, x, L)[0]

    def moment(x):
        return -RHO * g * width * quad(lambda s: (s - x) * height(s), x, L)[0]

    bent = quad(lambda x: (L - x) * moment(x) / (E * width * height(x) ** 3 / 12), 0, L, epsrel=1e-11)[0]
    sheared = quad(lambda x: force(x) / (kappa * G * width * height(x)), 0, L, epsrel=1e-11)[0]
    result = analyzed(robot, load=np.zeros(6), gravity=(0, 0, -g))
    assert result.twist[2] == pytest.approx(bent + sheared, rel=1e-9)
    assert result.base_wrench[2] == pytest.approx(-force(0), rel=1e-9) or result.base_wrench[2] == pytest.approx(
        force(0), rel=1e-9
    )
    found = result.beams["arm"]
    assert found.section_wrenches[7, 2] == pytest.approx(force(0.35 * L), rel=1e-9)
    assert found.section_wrenches[7, 4] == pytest.approx(-moment(0.35 * L), rel=1e-9)
    assert found.deflections[-1, 2] == pytest.approx(result.twist[2], rel=1e-12)
    middle = quad(
        lambda x: (L / 2 - x) * moment(x) / (E * width * height(x) ** 3 / 12) + force(x) / (kappa * G * width * height(x)),
        0,
        L / 2,
    )[0]
    assert found.deflections[10, 2] == pytest.approx(middle, rel=1e-9)
    assert found.mass == pytest.approx(RHO * width * L * (first + last) / 2, rel=1e-12)
    energy = (
        quad(
            lambda x: moment(x) ** 2 / (E * width * height(x) ** 3 / 12) + force(x) ** 2 / (kappa * G * width * height(x)), 0, L
        )[0]
        / 2
    )
    assert found.strain_energy == pytest.approx(energy, rel=1e-9)


def test_stress():
    """Bending stress 32 M / π d³ of a cone, largest where d is 3/2 of that at the loaded end."""
    first, last, P = 0.05, 0.02, 100.0
    result = analyzed(cone(first, last), load=[0, 0, -P, 0, 0, 0], gravity=(0, 0, 0)).beams["arm"]
    x = result.stations * L
    along = 32 * P * (L - x) / np.pi / (first + (last - first) * x / L) ** 3
    assert result.stress == pytest.approx(along.max(), rel=2e-3)
    exact = 32 * P * L / (first - last) * (last / 2) / np.pi / (1.5 * last) ** 3
    assert result.stress == pytest.approx(exact, rel=2e-3)


def test_stress_at_a_step_and_beside_the_line():
    """At a step the weaker section counts, also between the stations of results; a force beside the centroid bends."""
    robot = arm(
        (0, rectangle(0.04, 0.06)), (0.33, rectangle(0.04, 0.06)), (0.33, rectangle(0.04, 0.03)), (1, rectangle(0.04, 0.03))
    )
    result = analyzed(robot, load=[0, 0, -100.0, 0, 0, 0], gravity=(0, 0, 0)).beams["arm"]
    assert result.stress == pytest.approx(6 * 100 * 0.67 * L / (0.04 * 0.03**2), rel=2e-3)
    robot = arm((0, rectangle(0.04, 0.06), "0 0.01"), (1, rectangle(0.04, 0.06), "0 0.01"))
    result = analyzed(robot, load=[1000.0, 0, 0, 0, 0, 0], gravity=(0, 0, 0)).beams["arm"]
    assert result.stress == pytest.approx(1000 / (0.04 * 0.06) * (1 + 6 * 0.01 / 0.06), rel=1e-9)


@pytest.mark.parametrize(
    ("both", "roots"), [(False, [3.82379, 18.3173, 47.2648]), (True, [4.62515, 19.5476, 48.5789])], ids=["wedge", "cone"]
)
def test_frequencies_from_the_literature(both, roots):
    """Cantilevers tapered to one half, in depth alone and in both sides: B. Downs, J. Appl. Mech. 44 (1977), 737-742."""
    d = 1e-3 * L
    robot = cone(d, d / 2) if both else arm((0, rectangle(d, d)), (1, rectangle(d, d / 2)), more='shear_coefficient="inf"')
    gyration = d / 4 if both else d / np.sqrt(12)
    frequencies = 2 * np.pi * ks.modes(robot.assemble(), count=8).frequencies
    for root in roots:
        expected = root * gyration / L**2 * np.sqrt(E / RHO)
        assert np.min(np.abs(frequencies / expected - 1)) < 1e-5


@pytest.mark.parametrize("last", [0.02, 0.005])
def test_frequencies_converge(last, monkeypatch):
    frequencies = []
    for degree in (profile._DEGREE, profile._DEGREE + 4):
        monkeypatch.setattr(profile, "_DEGREE", degree)
        frequencies.append(ks.modes(cone(0.05, last, mass=1.0).assemble(), count=10).frequencies)
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-8)


def test_buckling_of_a_cone():
    """A column clamped at the thick end, under a force at the free end: y = x (A cos k/x + B sin k/x) with k² = P a⁴ / E I_a, and
    x from the apex, is zero at the free end a and has no slope at b (S. P. Timoshenko and J. M. Gere, Theory of Elastic
    Stability, section 2.14)."""
    first, last = 0.04, 0.02
    a = L * last / (first - last)
    b = a + L

    def slope(k):
        return np.sin(k / b - k / a) - k / b * np.cos(k / b - k / a)

    k = brentq(slope, 1.7 / (1 / a - 1 / b), 4.6 / (1 / a - 1 / b), xtol=1e-14)
    P = k**2 / a**4 * E * np.pi * last**4 / 64
    result = analyzed(cone(first, last), load=[-P / 10, 0, 0, 0, 0, 0], gravity=(0, 0, 0))
    assert result.buckling().load_factors[0] == pytest.approx(10, rel=2e-3)  # with the column's own shortening
    assert result.beams["arm"].euler_ratio == pytest.approx(0.1, rel=2e-3)


# ---- uniform beams, one after the other


def results_alike(robot, expected, within=1e-9):
    result, theirs = analyzed(robot), analyzed(expected)
    for name in ("twist", "compliance", "base_wrench", "strain_energy"):
        alike(getattr(result, name), getattr(theirs, name), within, name)
    assert result.buckling(2).load_factors == pytest.approx(theirs.buckling(2).load_factors, rel=max(within, 1e-5))
    corrections = [found.second_order.twist - found.twist for found in (result, theirs)]
    alike(*corrections, 2e-3)  # corrections of a uniform beam and of its two halves differ by 1e-3
    first, second = (ks.modes(machine.assemble(), count=6).frequencies for machine in (robot, expected))
    assert first == pytest.approx(second, rel=max(within, 1e-8))


def test_steps_are_welded_beams():
    steps = [(0.0, 0.05), (0.3, 0.05), (0.3, 0.03), (0.75, 0.03), (0.75, 0.02), (1.0, 0.02)]
    robot = arm(*((at, circle(d)) for at, d in steps), mass=2.0)
    pieces = [(0.3 * L, circle(0.05), (0, 0)), (0.45 * L, circle(0.03), (0, 0)), (0.25 * L, circle(0.02), (0, 0))]
    results_alike(robot, chain(pieces, mass=2.0, times=3))


def test_offsets_are_rigid_links():
    """A beam beside the line is a uniform beam between rigid links; with a step of offset, two of them."""
    section = rectangle(0.03, 0.05)
    robot = arm((0, section, "0.02 -0.03"), (1, section, "0.02 -0.03"), mass=2.0)
    results_alike(robot, chain([(L, section, (0.02, -0.03))], mass=2.0, times=4))
    robot = arm((0, section, "0.02 0"), (0.4, section, "0.02 0"), (0.4, section, "0 0.01"), (1, section, "0 0.01"), mass=2.0)
    results_alike(robot, chain([(0.4 * L, section, (0.02, 0)), (0.6 * L, section, (0, 0.01))], mass=2.0, times=4))


def test_tapered_with_offset_between_many_uniform_beams():
    """Uniform beams with the sections in the middles of n pieces differ by O(n⁻²); Richardson's extrapolation is nearer."""

    def of(n):
        middles = ((np.arange(n) + 0.5) / n).tolist()
        pieces = [(L / n, rectangle(0.05 - 0.02 * x, 0.06 - 0.04 * x), (0.02 * x, -0.01 * x)) for x in middles]
        robot = chain(pieces, mass=1.0)
        result = analyzed(robot)
        values = [result.twist, result.compliance.ravel(), result.second_order.twist]
        return values, ks.modes(robot.assemble(), count=3).frequencies, result.buckling().load_factors

    robot = arm((0, rectangle(0.05, 0.06)), (1, rectangle(0.03, 0.02), "0.02 -0.01"), mass=1.0)
    result = analyzed(robot)
    coarse, fine = of(12), of(24)
    for mine, a, b in zip([result.twist, result.compliance.ravel(), result.second_order.twist], coarse[0], fine[0], strict=True):
        alike(mine, (4 * b - a) / 3, 2e-4)
    for mine, a, b in zip(
        (ks.modes(robot.assemble(), count=3).frequencies, result.buckling().load_factors), coarse[1:], fine[1:], strict=True
    ):
        assert mine == pytest.approx((4 * b - a) / 3, rel=2e-4)


# ---- uniform beams with stations


def with_stations(robot):
    """Return a robot whose beams have densities, and the robot whose beams that are not telescopic have equal stations, too."""
    there, telescopes = robot.description, {beam.span.part.link for beam in robot.beams.values() if beam.telescopic}
    beams = {
        name: part if part.link in telescopes else replace(part, material=replace(part.material, density=3000.0))
        for name, part in there.beams.items()
    }
    stations = {
        name: part
        if part.link in telescopes
        else replace(part, section=Tapered.of(Station(at, part.section) for at in (0, 0.3, 0.3, 1)))
        for name, part in beams.items()
    }
    return ks.Robot(replace(there, beams=beams)), ks.Robot(replace(there, beams=stations))


@pytest.mark.few(4)
@pytest.mark.parametrize("which", ["linear_delta", 3, 8, 2, *range(9, 40)])
def test_equal_stations_change_nothing(which):
    robot = ks.load_robot(which) if isinstance(which, str) else write_randomly(random_hybrid(which), which)[1].robot()
    first, second = with_stations(robot)
    errors = {name: {"length": 1e-4} for name in robot.beams}
    try:
        expected = analyzed(first, assembly_errors=errors)
    except ks.KinetostaticsError as error:
        with pytest.raises(ks.KinetostaticsError) as other:
            analyzed(second, assembly_errors=errors)
        assert str(other.value) == str(error)
        return
    result = analyzed(second, assembly_errors=errors)
    for name in ("twist", "compliance", "actuator_forces", "joint_wrenches", "contributions", "base_wrench"):
        alike(getattr(result, name), getattr(expected, name), name=name)
    try:
        beams = result.beams
    except ks.StaticsError as error:
        assert "pass it both ways" in str(error)
        return
    for name, theirs in expected.beams.items():
        for quantity in ("mass", "section_wrenches", "deflections", "rotations", "stress", "strain_energy", "points"):
            alike(getattr(beams[name], quantity), getattr(theirs, quantity), name=quantity)
    alike(result.second_order.twist, expected.second_order.twist, 1e-6)
    assert result.buckling().load_factors == pytest.approx(expected.buckling().load_factors, rel=1e-5)
    frequencies = ks.modes(second.assemble()).frequencies
    assert frequencies == pytest.approx(ks.modes(first.assemble()).frequencies, rel=1e-9)


# ---- motion, derivatives, compiled code


def swinging(*parts):
    """A pendulum of given links and beams, on an actuated joint between base and "arm"."""
    ends = [link("base"), link("platform", 2.0), joint("swing", "revolute", "base", "arm", axis="0.2 1 0.3")]
    return robot_of(*ends, *parts, '<transmission name="t"><joint name="swing"/></transmission>')


def test_motion():
    """Inertial loads along a beam with steps and offsets equal those of welded uniform beams between rigid faces."""
    section, thin = rectangle(0.03, 0.05), rectangle(0.02, 0.03)
    stations = [(0, section, "0.02 0"), (0.4, section, "0.02 0"), (0.4, thin, "0 0.01"), (1, thin, "0 0.01")]
    one = swinging(link("arm"), joint("tip", "fixed", "arm", "platform", f"{L} 0 0"), beam("arm", *stations))
    parts, at, before = [link("arm")], "arm", np.zeros(2)
    for k, (length, element, beside) in enumerate([(0.4 * L, section, (0.02, 0)), (0.6 * L, thin, (0, 0.01))]):
        y, z = beside - before
        parts += [link(f"piece_{k}"), joint(f"start_{k}", "fixed", at, f"piece_{k}", f"0 {y} {z}")]
        parts += [link(f"face_{k}"), joint(f"end_{k}", "fixed", f"piece_{k}", f"face_{k}", f"{length} 0 0")]
        parts.append(f'<beam link="piece_{k}" from="start_{k}" to="end_{k}" {MATERIAL}>{element}</beam>')
        at, before = f"face_{k}", np.array(beside)
    two = swinging(*parts, joint("tip", "fixed", at, "platform", f"0 {-before[0]} {-before[1]}"))
    motion = ks.Motion({"swing": 3.0}, {"swing": -40.0})
    first, second = (ks.analyze(robot.assemble(actuators={"swing": 0.3}), load=LOAD, motion=motion) for robot in (one, two))
    for name in ("twist", "base_wrench", "actuator_forces"):
        alike(getattr(first, name), getattr(second, name), name=name)
    beams = second.beams
    for at, (name, theirs) in ((0.2, ("piece_0", 0.5)), (0.7, ("piece_1", 0.5))):
        k, other = round(20 * at), round(20 * theirs)
        arm = np.array([0, 0.02, 0] if name == "piece_0" else [0, 0, 0.01])
        ours, expected = first.beams["arm"], beams[name]
        force, moment = np.split(expected.section_wrenches[other], 2)
        alike(ours.section_wrenches[k], np.concatenate([force, moment + np.cross(arm, force)]), 1e-9)
        turned = expected.rotations[other]
        alike(ours.deflections[k], expected.deflections[other] - np.cross(turned, expected.axes @ arm), 1e-9)
    plain = ks.analyze(one.assemble(actuators={"swing": 0.3}), load=LOAD).beams["arm"]
    assert np.abs(plain.section_wrenches - first.beams["arm"].section_wrenches).max() > 1.0


def test_sensitivities():
    """The deflection P L³ ∝ 1 / a³ b of a cone changes by −3 % and −1 % with 1 % of its diameters a and b."""
    pose = cone().assemble()
    names = ["arm.station_1.outer_diameter", "arm.station_2.outer_diameter"]
    table = ks.sensitivities(pose, names, ["twist"], load=[0, 0, -100.0, 0, 0, 0], gravity=(0, 0, 0))
    z = ks.analyze(pose, load=[0, 0, -100.0, 0, 0, 0], gravity=(0, 0, 0)).twist[2]
    for name, power, value in zip(names, (-3, -1), (0.05, 0.02), strict=True):
        assert table[name].twist[2] == pytest.approx(power * z / value, rel=1e-5)


def test_compiled():
    robot = with_taper(ks.load_robot("linear_delta"))
    names = list(robot.assemble().actuators)
    values = [float(value) for value in robot.assemble().actuators.values()]
    compiled, plain = (
        ks.compile(robot, outputs=("twist", "stiffness", "actuator_forces"), engine=e) for e in ("compiled", "numpy")
    )
    given = dict(zip(names, values, strict=True))
    result, expected = compiled(**given, load=LOAD), plain(**given, load=LOAD)
    for name in ("twist", "stiffness", "actuator_forces"):
        alike(result[name], expected[name], 1e-9, name)
    alike(result["twist"], analyzed(robot, gravity=(0, 0, -9.81)).twist, 1e-9)


def with_taper(robot):
    beams = {
        name: replace(
            part,
            section=Tapered.of(
                [
                    Station(0, part.section),
                    Station(1, replace_sizes(part.section, 0.7), (0.002, 0.001) if part.y_axis else (0.0, 0.0)),
                ]
            ),
            material=replace(part.material, density=2000.0),
        )
        for name, part in robot.description.beams.items()
    }
    return ks.Robot(replace(robot.description, beams=beams))


def replace_sizes(tube, factor):
    return type(tube).of(tube.outer_diameter * factor, tube.inner_diameter * factor)


def test_limbs_are_alike_only_with_stations_in_each():
    """Beams with and without stations in limbs that are otherwise equal."""
    robot = ks.load_robot("linear_delta")
    there = robot.description
    first, *rest = there.beams.items()
    section = Tapered.of(Station(at, first[1].section) for at in (0, 1))
    dense = {name: replace(part, material=replace(part.material, density=2000.0)) for name, part in there.beams.items()}
    mixed = dense | {first[0]: replace(dense[first[0]], section=section)}
    result, expected = (analyzed(ks.Robot(replace(there, beams=beams))) for beams in (mixed, dense))
    alike(result.twist, expected.twist)
    alike(result.beams[rest[0][0]].deflections, expected.beams[rest[0][0]].deflections)


# ---- files and descriptions


def test_round_trip_and_direction(tmp_path):
    """Written and read again; from the other end with mirrored stations, the results are equal."""
    robot = arm(
        (0, rectangle(0.05, 0.06)), (0.3, rectangle(0.04, 0.05), "0.01 0"), (1, rectangle(0.03, 0.02), "0.02 -0.01"), mass=1.0
    )
    path = tmp_path / "arm.urdf"
    ks.save_robot(robot, path)
    again = ks.load_robot(path)
    assert again.description.beams == robot.description.beams
    part = robot.description.beams["arm"]
    ends = {"start": ks.description.BeamEnd("tip"), "end": ks.description.BeamEnd("wall")}
    mirrored = [Station(1 - s.at, s.section, (s.offset[0], -s.offset[1])) for s in part.section.stations[::-1]]  # z = x × y
    other = ks.Robot(replace(robot.description, beams={"arm": replace(part, section=Tapered.of(mirrored), **ends)}))
    result, expected = analyzed(other), analyzed(robot)
    alike(result.twist, expected.twist)
    alike(result.beams["arm"].stress, expected.beams["arm"].stress)
    alike(result.beams["arm"].deflections, expected.beams["arm"].deflections)


@pytest.mark.parametrize(
    ("stations", "message"),
    [
        ([(0, circle(0.02))], "its stations are at 0; give one at 0, one or two at each place, one at 1"),
        ([(0, circle(0.02)), (0.9, circle(0.02))], "its stations are at 0, 0.9; give"),
        ([(0, circle(0.02)), (0.5, circle(0.02)), (0.4, circle(0.02)), (1, circle(0.02))], "at 0, 0.5, 0.4, 1; give"),
        ([(0, circle(0.02)), *[(0.5, circle(0.02))] * 3, (1, circle(0.02))], "at 0, 0.5, 0.5, 0.5, 1; give"),
        ([(0, circle(0.02)), (1, rectangle(0.02, 0.02))], "its stations are Rectangle, Tube; give uniform sections of one kind"),
        ([(0, circle(0.02)), (1, "")], "<station> has no sections; give one of <circle>, <tube>"),
        ([(0, circle(0.02)), (1, circle(0.02), "0 x")], "'x' is not a number"),
        ([(0, circle(0.02)), (1, circle(0.02), "0.01")], "must be two numbers, not 1"),
    ],
)
def test_errors(stations, message):
    with pytest.raises(ks.RobotFileError, match=message.replace("(", r"\(")):
        arm(*stations)


def test_refused():
    robot = cone()
    with pytest.raises(ks.ArgumentError, match=r"verify cannot check arm: .*; verify a copy of the robot with these"):
        ks.verify(robot.assemble())
    part = robot.description.beams["arm"]
    with pytest.raises(ks.RobotFileError, match="beam> 'arm' has stations, but no density; give one, so that its mass follows"):
        ks.Robot(replace(robot.description, beams={"arm": replace(part, material=replace(part.material, density=None))}))
    with pytest.raises(ks.ArgumentError, match="an offset of its stations is not finite"):
        Tapered.of([Station(0, part.section.stations[0].section, (np.nan, 0)), *part.section.stations[1:]])
    mast = ks.load_robot("3rps").description
    name, telescope = next(iter(mast.beams.items()))
    section = Tapered.of(Station(at, telescope.section) for at in (0, 1))
    changed = replace(telescope, section=section, material=replace(telescope.material, density=1000.0))
    with pytest.raises(ks.RobotFileError, match="its section varies; a telescopic beam has one section: give one, or each link"):
        _ = ks.Robot(replace(mast, beams=mast.beams | {name: changed})).beams


SPRING = (
    '<spring name="s" stiffness="2e4" free_length="0.1"><predecessor link="base"><origin xyz="0 0 0.4"/></predecessor>'
    '<successor link="platform"/></spring>'
)


def test_springs():
    """The tangent stiffness of a robot with a spring depends on the forces inside its beams, by NumPy and in maps."""
    ends = [link("base"), link("arm"), link("platform", 2.0), joint("wall", "fixed", "base", "arm")]
    tip = joint("tip", "fixed", "arm", "platform", f"{L} 0 0")
    one, two = (
        robot_of(*ends, tip, SPRING, beam("arm", *stations) if stations else f'<beam link="arm" {MATERIAL}>{circle(0.05)}</beam>')
        for stations in ([(at, circle(0.05), "0 0") for at in (0, 1)], ())
    )
    expected = analyzed(two)
    loads = np.outer(np.linspace(0.5, 1, 50), LOAD)
    for load in (LOAD, loads):
        result, theirs = analyzed(one, load=load), analyzed(two, load=load)
        alike(result.twist, theirs.twist, 1e-7)
        alike(result.compliance, theirs.compliance, 1e-7)
    f = ks.compile(one, (), outputs=("twist", "stiffness"))
    alike(f(load=LOAD, gravity=GRAVITY)["twist"], expected.twist, 1e-9)
    assert ks.modes(one.assemble()).frequencies == pytest.approx(ks.modes(two.assemble()).frequencies, rel=1e-7)
