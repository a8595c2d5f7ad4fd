"""Reports of robots and results: their words and numbers, and plain values that equal the arrays."""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import package_robots
import pytest
import small_robots as small
from hybrid_robots import random_hybrid, write_randomly
from package_robots import robot

import kinetostatics as ks
from kinetostatics.checks.chains import bodies_of, joints_of
from kinetostatics.checks.check import diagnose
from kinetostatics.checks.diagnosis import section_words
from kinetostatics.quantities import reported_names
from kinetostatics.reports.parts import BEAM_DATA
from kinetostatics.sections import Rectangle, RectangularTube, Section, Tube


@cache
def configuration_2():
    pose = robot("3rps").assemble(
        platform={"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(10)}, orientation="tilt_torsion"
    )
    return ks.analyze(pose, gravity=(0, 0, -9.8))


@cache
def batch():
    """Four poses of the 2PRU-UPR of which the last cannot be reached."""
    pose = robot("2pru_upr").assemble(platform={"z": np.array([[0.5, 0.6], [0.55, 3.0]]), "rx": 0.1, "ry": 0})
    return ks.analyze(pose)


def actuated(spec, wanted):
    """Return a spec in which the joints whose names satisfy ``wanted`` are actuated."""
    limbs = (
        replace(limb, joints=tuple(replace(joint, actuated=wanted(joint.name)) for joint in limb.joints)) for limb in spec.limbs
    )
    return replace(spec, limbs=tuple(limbs))


def whole(item):
    return str(item.report())


def part(text, title):
    """Return the lines of the part of a report whose title begins with ``title``."""
    found = re.search(rf"^{re.escape(title)}[^\n]*\n((?:  [^\n]*\n?|\n(?=  ))*)", text, re.MULTILINE)
    assert found, f"no part {title!r} in\n{text}"
    return [line.strip() for line in found[1].splitlines() if line.strip()]


def row(text, title, name):
    """Return the cells, split at white space, of the only row of a part that begins with ``name``."""
    rows = [line for line in part(text, title) if line.startswith(name + " ")]
    assert len(rows) == 1, (name, rows)
    return rows[0].split()


@pytest.mark.parametrize(
    ("section", "words"),
    [
        (Tube.of(0.1), "circle ⌀100 mm"),
        (Tube.of(0.06, 0.05), "tube ⌀60/50 mm"),
        (Rectangle.of(0.04, 0.02), "rectangle 40×20 mm"),
        (RectangularTube.of(0.04, 0.02, 0.003), "box 40×20×3 mm"),
        (Section(1e-4, 2e-9, 3e-9, 4e-9), "A 100 mm², I_y 2000, I_z 3000 mm⁴"),
    ],
)
def test_sections_are_described_by_shape_and_size(section, words):
    assert section_words(section) == words


# ---- the result ------------------------------------------------------------------------------------------------------

# "recovered" values of the paper's configuration 2 of the 3RPS, see paper_tables.json: twist in nm and µrad, forces in N
TWIST = {"x": 49.6878, "y": 52.6152, "z": -74.11, "rx": 0.0525908, "ry": -0.0222135, "rz": 0.0258967}
ALONG_THE_ROD = [63.8998, 77.2695, 74.0326]
ACROSS_THE_ROD = [1.0048, 0.5385, 1.5125]
DRIVES = [385.4348, 364.7818, 367.832]


def test_report_of_configuration_2_equals_the_paper():
    text = whole(configuration_2())
    assert text.splitlines()[0] == "Analysis of '3rps': OK; o moves by 103.6 nm, the platform turns by 62.69 nrad"
    twist = part(text, "Twist of the platform at o, world axes")
    assert twist[0].split() == ["load", "platform_weight", "limb_1", "limb_2", "limb_3", "total"]
    for line, (name, expected) in zip(twist[1:], TWIST.items(), strict=True):
        cells = line.split()
        assert cells[:2] == [name, "[nm]" if len(name) == 1 else "[µrad]"]
        assert float(cells[-1]) == pytest.approx(expected, abs=6e-4 if len(name) == 1 else 6e-6)
        assert sum(map(float, cells[2:-1])) == pytest.approx(float(cells[-1]), abs=3e-3 if len(name) == 1 else 3e-5)
    limbs = part(text, "Limbs")
    along = [line.split() for line in limbs if "force along limb axis" in line]
    across = [line.split() for line in limbs if "force ∥ revolute" in line]
    for cells, value in zip([*along, *across], [*ALONG_THE_ROD, *ACROSS_THE_ROD], strict=True):
        assert cells[-1] == "N" and cells[-3] == "constraint"
        assert abs(float(cells[-2])) == pytest.approx(value, abs=6e-4)
    assert sum(line.split()[-3] == "attached" for line in limbs[1:]) == 3
    for k, expected in enumerate(DRIVES, 1):
        cells = row(text, "Actuators", f"prismatic_{k}")
        assert float(cells[3]) == pytest.approx(expected, abs=6e-3)
        assert (cells[2], cells[4]) == ("mm", "N")
        assert float(row(text, "Beams", f"rod_{k}")[3]) == pytest.approx(-expected, abs=6e-3)
    assert part(text, "Warnings") == ["none"]


def test_report_prints_pose_and_units():
    text = whole(configuration_2())
    assert part(text, "Pose")[:4] == [
        "o            x -1.4276  y 0.5196  z 500.0000 mm",
        "orientation  azimuth -170.0000°  tilt 10.0000°  torsion 0°  (tilt and torsion)",
        "actuators    prismatic_1 -5.6969 mm, prismatic_2 -61.7645 mm, prismatic_3 -51.9018 mm",
        "gravity      (0, 0, -9.800) m/s²",
    ]
    assert part(text, "Joints")[0].endswith("force [N]  moment [N·m]")
    assert row(text, "Joints", "spherical_2")[-1] == "0"  # a ball carries no moment: noise is not shown
    assert [line.split()[0] for line in part(text, "Ground")] == ["force", "moment"]
    header = part(text, "Beams")[0]
    for title in ("length [mm]", "mass [kg]", "stress [MPa]", "N/N_Euler [%]", "end displacement [nm]"):
        assert title in header
    stiffness = part(text, "Stiffness")
    assert stiffness[1].startswith("x [N/µm]") and stiffness[4].startswith("rx [kN·m/mrad]")
    assert float(stiffness[3].split()[2]) == pytest.approx(configuration_2().stiffness[2, 2] / 1e6, abs=6e-3)
    free = 1 / configuration_2().compliance[2, 2]
    assert float(stiffness[3].split()[3]) == pytest.approx(free / 1e6, abs=6e-3)


def test_rounding_noise_is_shown_as_zero():
    text = whole(ks.analyze(robot("3rps").assemble()))
    for name in ("x", "y", "rx", "ry", "rz"):
        assert row(text, "Twist", name)[-1] == "0"
    assert row(text, "Twist", "z")[-1] != "0"
    assert "e-1" not in "\n".join(text.split("Twist", 1)[1:])


def test_couples_are_in_newton_metres():
    text = whole(ks.analyze(robot("2pru_upr").assemble()))
    couples = [line.split() for line in part(text, "Limbs") if "couple" in line]
    assert len(couples) == 3 and all(cells[-1] == "N·m" for cells in couples)


def test_revolute_actuators_and_loads_have_their_units():
    four_bar = small.robot_of(small.four_bar())
    text = whole(ks.analyze(four_bar.assemble(actuators={"foot_1": 0.1}), load=[10, 0, 5, 0, 2, 0]))
    name, position, _, unit, *_ = row(text, "Actuators", "foot_1")
    assert (name, position, unit) == ("foot_1", "5.7296°", "N·m")
    assert "load at o    force (10.000, 0, 5.000) N, moment (0, 2.0000, 0) N·m" in part(text, "Pose")


def test_exceeded_limits_are_warnings():
    text = whole(ks.analyze(robot("3rps").assemble(platform={"z": 1.5, "rx": 0, "ry": 0})))
    assert "LIMIT_EXCEEDED, a joint is outside its limit; all results remain valid" in text
    assert sum("is beyond its limits" in line for line in part(text, "Warnings")) == 3


def test_unreachable_and_singular_poses_print_no_numbers():
    pose = robot("2pru_upr").assemble(platform={"z": 3.0, "rx": 0, "ry": 0}, on_failure="nan")
    text = whole(ks.analyze(pose, on_failure="nan"))
    assert "UNREACHABLE, the loops do not close" in text
    assert "Twist" not in text and "nan" not in text
    loose = small.robot_of(actuated(small.four_bar(), lambda name: False))
    text = whole(ks.analyze(loose.assemble(), on_failure="nan"))
    assert "SINGULAR" in text.splitlines()[0]
    assert part(text, "Free motions")[0].startswith("- the platform: a rotation about the axis (0, ")


def test_cantilever_report_has_no_actuators():
    text = whole(ks.analyze(small.robot_of(small.cantilever()).assemble(), load=[0, 0, -100, 0, 0, 0]))
    assert "actuators    none" in part(text, "Pose")
    assert "Actuators" not in text
    assert sum("constraint" in line for line in part(text, "Limbs")) == 6


# ---- a batch ---------------------------------------------------------------------------------------------------------


def test_batch_report_has_status_counts_and_extremes():
    text = whole(batch())
    assert text.splitlines()[0].startswith(
        "Analysis of '2pru_upr': 4 poses, batch shape (2, 2): 3 OK, 1 UNREACHABLE; o moves by "
    )
    assert row(text, "Status", "OK")[1] == "3"
    assert row(text, "Status", "UNREACHABLE")[1] == "1"
    assert row(text, "Extremes", "platform z") == "platform z mm 500.00 [0, 0] 600.00 [0, 1]".split()
    forces = batch().actuator_forces["prismatic_3"]
    cells = row(text, "Extremes", "force of prismatic_3")
    assert cells[3] == "N"
    assert float(cells[4]) == pytest.approx(np.nanmin(forces), abs=6e-3)
    size = 1e6 * np.linalg.norm(batch().twist[..., :3], axis=-1)
    cells = row(text, "Extremes", "displacement of o")
    assert cells[3] == "µm" and float(cells[-3]) == pytest.approx(np.nanmax(size), abs=6e-4)
    text = whole(ks.analyze(robot("2pru_upr").assemble(platform={"z": np.array([3.0, 4.0]), "rx": 0, "ry": 0})))
    assert row(text, "Status", "UNREACHABLE")[1] == "2" and "Extremes" not in text


def test_batch_of_loads_at_one_pose_keeps_its_shape():
    loads = np.zeros((3, 6))
    loads[:, 2] = [-100, 0, 100]
    result = ks.analyze(robot("3rps").assemble(), load=loads)
    assert "3 poses, batch shape (3,)" in whole(result)
    found = result.to_dict()
    assert found["configuration"]["shape"] == [] and found["shape"] == [3]
    np.testing.assert_allclose(found["load"], loads, rtol=1e-14)


# ---- plain numbers ---------------------------------------------------------------------------------------------------


def assert_same(plain, value):
    """Compare plain values with an array, a tuple of names, or a mapping of these."""
    if isinstance(value, Mapping):
        assert list(plain) == list(value)
        for key in value:
            assert_same(plain[key], value[key])
    elif isinstance(value, tuple):
        assert plain == list(value)
    else:
        np.testing.assert_array_equal(np.array(plain, dtype=float).reshape(np.shape(value)), value)


@pytest.mark.parametrize("make", [configuration_2, batch])
def test_json_round_trip_equals_the_arrays(make):
    result = make()
    found = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    parts = [(found, result, reported_names(""))]
    parts += [
        (found["limbs"][name], limb, ["labels", "attached_labels", *reported_names("limbs")])
        for name, limb in result.limbs.items()
    ]
    parts += [(found["beams"][name], beam, BEAM_DATA) for name, beam in result.beams.items()]
    parts.append((found["configuration"], result.configuration, ("q", "residual", "platform", "actuators")))
    for plain, item, names in parts:
        for name in names:
            assert_same(plain[name], getattr(item, name))


def test_plain_values_of_a_batch_have_its_shape():
    found = batch().to_dict()
    assert found["status"] == [["OK", "OK"], ["OK", "UNREACHABLE"]]
    assert found["twist"][1][1] == [None] * 6
    assert found["limbs"]["limb_1"]["units"] == ["N", "N", "N·m"]
    over = ks.analyze(robot("3rps").assemble(platform={"z": np.array([0.5, 1.5]), "rx": 0, "ry": 0})).to_dict()
    exceeded = over["configuration"]["limits_exceeded"]["prismatic_1"]
    assert exceeded["where"] == [False, True]


# ---- the robot, see tests/cli/test_check_golden.py too --------------------------------------------------------------


def test_singular_zero_pose_is_named_in_the_warning():
    # coupler and follower in one line: at zero, and only near it, the locked crank does not hold the platform
    y = (0, 1, 0)
    limbs, beams = [], []
    for n, foot, head in ((1, (0, 0, 0), (0, 0, 0.3)), (2, (1.0, 0, 0), (0.4, 0, 0.18))):
        joints = (small.Joint(f"foot_{n}", "R", foot, y, actuated=n == 1), small.Joint(f"head_{n}", "R", head, y))
        limbs.append(small.Limb(joints, (small.Link(f"crank_{n}"),)))
        beams.append(small.Beam(f"crank_{n}", f"crank_{n}", f"foot_{n}", f"head_{n}", small.circle(0.03)))
    flat = small.Spec(tuple(limbs), tuple(beams), o=(0.5, 0, 0), mass=1.0, com=(0.5, 0, 0))
    warnings = diagnose(small.robot_of(flat)).warnings
    assert any(text.startswith("at the zero pose ") for text in warnings), warnings


def test_plain_values_of_a_robot_have_mobility_and_graph():
    found = json.loads(json.dumps(robot("2pru_upr").to_dict(), allow_nan=False))
    mobility = found["mobility"]
    assert [mobility[name] for name in ("platform", "local", "redundant_constraints", "redundant_actuators")] == [3, 0, 3, 0]
    (redundancy,) = mobility["redundancies"]
    assert redundancy["count"] == 3 and redundancy["wrenches"] == ["a force along x", "a couple about z"]
    weights = robot("2pru_upr").weights.masses(robot("2pru_upr").zero_frames)
    assert found["mass"] == pytest.approx(float(weights.sum()), rel=1e-14)
    assert [limb["like"] for limb in found["limbs"]] == [None, "limb_1", None]
    chain = found["limbs"][2]["graph"]["chain"]
    assert [item["type"] for item in chain] == ["joint", "body", "joint", "body", "joint"]
    assert chain[0]["joints"] == ["universal_3_x", "universal_3_y"] and chain[1]["names"] == ["cylinder_3"]
    assert (chain[2]["name"], chain[2]["kind"], chain[2]["actuated"]) == ("prismatic_3", "prismatic", True)
    assert (found["beams"][2]["start"], found["beams"][2]["end"]) == ("universal_3", "revolute_3")
    assert found["limbs"][2]["constraint_wrenches"][2] == "couple ⟂ universal_3"
    assert found["beams"][2]["telescopic"] is True and found["beams"][0]["length"] == pytest.approx(0.7)
    assert found["problems"] == found["warnings"] == []


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", range(3))
def test_reports_of_random_robots_can_be_written(seed):
    robot = small.robot_of(small.random_spec(["Rpus", "PUr", "uPS", "SpS"], seed))
    assert whole(robot)
    json.dumps(robot.to_dict(), allow_nan=False)
    result = ks.analyze(robot.assemble(), on_failure="nan")
    assert whole(result)
    json.dumps(result.to_dict(), allow_nan=False)


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [1, 0, 9, 13, 22])
def test_facts_of_hybrid_limbs_have_every_joint_once(seed):
    """Frames, rings, braces and hanging branches; redundancies and freedoms add up to those of the mobility."""
    one = write_randomly(random_hybrid(seed), seed)[1].robot()
    facts = diagnose(one)
    assert str(one)
    assert sum(item.count for item in facts.mobility.redundancies) == one.mobility.redundant_constraints
    assert sum(item.count for item in facts.mobility.local_freedoms) == one.mobility.local
    assert len(facts.mobility.coordinates) == one.mobility.platform
    for found, limb in zip(facts.limbs, one.topology.limbs, strict=True):
        chains = [found.graph.chain, *(item.chain for item in found.graph.hanging)]
        shown = [joint for chain in chains for step in joints_of(chain) for joint in step.joints]
        moving = {edge.joint for edge in (*limb.edges, *limb.branches) if edge.joint and _moves(one, edge.joint)}
        assert len(shown) == len(set(shown)) and moving <= set(shown)
        assert {edge.span for edge in limb.edges if edge.span} <= {name for chain in chains for name in bodies_of(chain)}
        assert len(set(found.constraint_wrenches)) == len(found.constraint_wrenches)
    for item in facts.mobility.redundancies:
        inside = [limb for limb in one.topology.all_limbs if item.limbs == (limb.name,)]
        for limb in inside:
            assert set(item.joints) <= {edge.joint for edge in limb.edges}


def _moves(one, joint):
    return one.mechanism.connections[joint].type.name != "fixed"


def test_hinge_axes_relabel_the_limb_axes_as_in_the_paper():
    """The paper's PRU limbs have x along the hinge: their attached force is along y there, W_ig1 = −0.5 q_iy L."""
    found = ks.analyze(package_robots.robot("2pru_upr").assemble(), gravity=(0, 0, 9.8))
    ours, theirs = whole(found), str(found.report(hinge_axes={"limb_1": "x", "limb_2": "x"}))
    intensity = {}
    for text, axis in ((ours, "x"), (theirs, "y")):
        line = next(line for line in text.splitlines() if f"force along limb {axis} at universal_1" in line)
        intensity[axis] = float(line.split()[-2])
    limb = found.limbs["limb_1"]
    rod = found.robot.description.beams["rod_1"]
    weight = rod.density * rod.section.area * found.gravity
    along = found.beams["rod_1"].points[-1] - found.beams["rod_1"].points[0]
    length = np.linalg.norm(along)
    y = np.cross(along / length, [1.0, 0, 0])  # z × x, x along the hinge
    sign = np.sign(limb.attached_wrenches[:3, 0] @ y)
    assert sign * float(limb.attached_intensities[0]) == pytest.approx(-0.5 * weight @ y * length, rel=1e-12)  # Eq. (18)
    assert intensity["y"] == -intensity["x"] != 0
    assert "limb x" not in theirs.partition("limb_3")[0].partition("\nLimbs")[2]
    with pytest.raises(ks.ArgumentError, match="no limb 'limb_9'"):
        found.report(hinge_axes={"limb_9": "x"})
    with pytest.raises(ks.ArgumentError, match="must be 'x' or 'y'"):
        found.report(hinge_axes={"limb_1": "z"})


# ---- the summary -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["3rps", "five_bar", "planar_3rrr"])
def test_summary_fits_25_lines_without_rounding_noise(name):
    result = ks.analyze(package_robots.robot(name).assemble())
    text = str(result)
    assert len(text.partition("\nWarnings")[0].splitlines()) <= 25
    assert not re.search(r"\de-\d|-0(?:\.0*)?(?![.\d])", str(result.report()))
    names = [line.split("  ")[1] for line in text.partition("\nSummary\n")[2].partition("\n\n")[0].splitlines()]
    assert [name for name in names if name][:5] == ["displacement", "rotation", "softest", "stiffest", "actuators"]


def test_summary_has_direction_and_sources_of_the_displacement():
    result = ks.analyze(package_robots.robot("3rps").assemble(), load=[0, 0, -500, 0, 0, 0])
    (row,) = (line for line in " ".join(str(result).split()).split("Summary")[1:])
    share = 100 * result.contributions["load"][2] / result.twist[2]
    assert f"nm, down; {share:.0f} % from the load, " in row and "% by deformation of rod_1" in row
    rigid = str(ks.analyze(small.robot_of(replace(small.four_bar(), beams=())).assemble(), on_failure="nan"))
    assert "0 µm: nothing is elastic" in rigid


@pytest.mark.parametrize("tilt", [0.0, 10.0])
def test_contributions_that_cancel_are_lengths_in_the_summary(tilt):
    """Of the tilted tripod, the limbs' weights move the platform by seven times its displacement, in opposite directions."""
    target = {"z": 0.5, "azimuth": np.radians(-170), "tilt": np.radians(tilt)}
    result = ks.analyze(package_robots.robot("3rps").assemble(platform=target, orientation="tilt_torsion"))
    size = np.linalg.norm(result.twist[:3])
    parts = {name: twist[:3] @ result.twist[:3] / size for name, twist in result.contributions.items()}
    text = " ".join(str(result).partition("Summary")[2].split())
    if sum(map(abs, parts.values())) > 2 * size:
        assert (
            tilt and f"; {1e9 * parts['limb_2']:.0f} nm from limb_2's weight, {1e9 * parts['limb_1']:.0f} nm from limb_1" in text
        )
    else:
        assert not tilt and re.search(r"; \d+ % from the platform's weight, \d+ % from limb_1's weight", text)


def test_revolutes_about_one_point_are_one_row():
    text = whole(ks.analyze(robot("gough_stewart").assemble()))
    assert row(text, "Joints", "spherical_1")[1:4] == ["spherical,", "3", "revolutes"] and "spherical_1_x" not in text


def test_result_at_a_tool_has_the_twist_of_the_tip():
    pose = robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0})
    result = ks.analyze(pose, load=[50, 0, -500, 0, 0, 0])
    tip = result.at_point((0.05, 0, 0.2))
    arm = pose.platform_frame[:3, :3] @ [0.05, 0, 0.2]
    shift = result.twist[:3] + np.cross(result.twist[3:], arm)
    np.testing.assert_allclose(tip.twist, [*shift, *result.twist[3:]], rtol=1e-12)
    parts = [twist for own in tip.source_contributions.values() for twist in own.values()]
    scale = np.abs(tip.twist).max()
    np.testing.assert_allclose(np.sum(parts, axis=0), tip.twist, atol=1e-9 * scale)
    np.testing.assert_allclose(np.sum(list(tip.contributions.values()), axis=0), tip.twist, atol=1e-12 * scale)
    np.testing.assert_allclose(tip.compliance @ tip.stiffness, np.eye(6), atol=1e-8)
    assert tip.seen_from(None) is result and "the tool's tip moves by" in repr(tip)
    np.testing.assert_array_equal(tip.to_dict()["twist"], result.twist)
    np.testing.assert_array_equal(tip.to_dict()["tool"]["twist"], tip.twist)


def test_hanging_rod_report_has_axial_forces_of_both_ends():
    """A hanging rod carries its own weight at its upper end, and the load alone at the lower one."""
    found = ks.analyze(small.robot_of(small.cantilever(1.0)).assemble(), gravity=(-10, 0, 0))
    beam = found.beams["arm"]
    header, line = part(whole(found), "Beams")[:2]
    assert header.index("N base end [N]") < header.index("N platform end [N]")
    ends = [float(cell) for cell in line.split()[3:5]]
    platform = -float(found.platform_weight[0])
    assert ends == pytest.approx([-platform - 10 * float(beam.mass), -platform], rel=1e-3)
