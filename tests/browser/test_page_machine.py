"""The machine of a page (engine.js) against Python: equilibrium, the drawn scene, the ends of lines, statuses."""

import itertools

import numpy as np
import package_robots
import pytest
from page_machine import answers, needs_node, relative

import kinetostatics as ks
from kinetostatics.parametric.parametric_robot import ParametricRobot
from kinetostatics.sections import Station, Tapered
from kinetostatics.viewer.cards import LARGEST_STRESS
from kinetostatics.viewer.computing import determining_coordinates
from kinetostatics.viewer.packing import Packing
from kinetostatics.viewer.scene import describe_scene
from kinetostatics.viewer.variations import vary_result

pytestmark = needs_node
QUICK = ("3rps", "2pru_upr", "five_bar")
ROBOTS = [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in package_robots.NAMES]
#: Poses of slow tests.
POSES = 200


def start_of(name):
    """Return a robot and a pose from which its platform can move."""
    robot = package_robots.robot(name)
    return robot, robot.assemble(actuators=dict.fromkeys(robot.description.actuated, 0.3)) if name == "ur10" else robot.assemble()


def random_cases(robot, pose, count, wide=1.0, seed=0):
    """Return random coordinates near a pose, loads and payloads: arguments of ``analyze`` of the page."""
    rng, names = np.random.default_rng(seed), determining_coordinates(pose)
    cases = []
    for _ in range(count):
        spans = {name: wide * rng.choice([0.02, 0.06, 0.15]) * (robot.length if name in "xyz" else 1.0) for name in names}
        at = {name: float(pose.platform[name]) + span * rng.uniform(-1, 1) for name, span in spans.items()}
        gravity = np.array([0, 0, -9.81]) + rng.uniform(-3, 3, 3)
        payload = [rng.uniform(1, 20), *rng.uniform(-0.2, 0.2, 3)]
        cases.append(
            {"platform": at, "load": rng.uniform(-500, 500, 6).tolist(), "gravity": gravity.tolist(), "payload": payload}
        )
    return cases


def by_python(robot, case, near=None):
    pose = robot.assemble(platform=case["platform"], near=near, on_failure="nan")
    payload = ks.Payload(case["payload"][0], case["payload"][1:])
    return ks.analyze(pose, case["load"], case["gravity"], payload=payload, on_failure="nan")


def numbers_of(result):
    pose = result.configuration
    kinds = {"platform": pose.platform, "actuators": pose.actuators, "actuator_forces": result.actuator_forces}
    return {"twist": result.twist, "stiffness": result.stiffness} | {key: list(kind.values()) for key, kind in kinds.items()}


@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_of_random_poses_and_loads_equal_those_of_python(name):
    """To 1e-12 of the largest number of each kind, or what Python's depend on the way to the pose; the statuses are the same."""
    robot, start = start_of(name)
    cases = random_cases(robot, start, 12 if name in QUICK else POSES)
    near = start if name == "ur10" else None
    given = ks.analyze(start)
    script = "if (given.near) machine.robot.zero = machine.pose; return machine.analyze(given)"
    found = answers(given, [(script, {**case, "near": near is not None}) for case in cases])
    statuses = set()
    for case, answer in zip(cases, found, strict=True):
        result = by_python(robot, case, near)
        assert answer["status"] == str(ks.Status(int(result.status)))
        statuses.add(answer["status"])
        if answer["twist"] is None:
            continue
        for key in ("platform", "actuators"):
            assert list(answer[key]) == list(getattr(result.configuration, key))
        again = None
        for key, wanted in numbers_of(result).items():
            mine = list(answer[key].values()) if isinstance(answer[key], dict) else answer[key]
            if (difference := relative(mine, wanted)) >= 1e-12:
                again = again or numbers_of(by_python(robot, case, result.configuration))
                assert difference < 1e-12 + relative(again[key], wanted), key
    assert "OK" in statuses or "LIMIT_EXCEEDED" in statuses


class Numbers(Packing):
    """A packing that keeps the numbers."""

    def path(self, values, width=1):
        return np.asarray(values, dtype=float).ravel()


def compare_scenes(scene, result):
    """Compare a drawn scene of the page with that of a result: stations at rest, their twists by contribution, arrows, cards."""
    drawn = describe_scene(result)
    expected = {**drawn.moving(Numbers()), **drawn.details(Numbers())}
    assert scene["contributions"] == list(expected["contributions"])
    K = len(scene["contributions"])
    points, wanted = (np.reshape(s["stations"]["pose"], (-1, 7))[:, :3] for s in (scene, expected))
    assert relative(points, wanted) < 1e-12
    for part in (slice(0, 3), slice(3, 6)):
        twists, wanted = (np.reshape(s["stations"]["twist"], (-1, K, 6))[..., part] for s in (scene, expected))
        assert relative(twists, wanted) < 1e-11
    arrows = {arrow["path"]: arrow for arrow in scene["arrows"]}
    force = max(np.abs(arrow["vector"]).max() for arrow in expected["arrows"])
    for arrow in expected["arrows"]:
        mine = arrows.pop(arrow["path"])
        assert mine["station"] == arrow["station"] and relative(mine["vector"], arrow["vector"], force) < 1e-11
    assert all(np.abs(arrow["vector"]).max() < 1e-9 * force for arrow in arrows.values())  # of zero length
    for path, card in expected["cards"].items():
        mine = scene["cards"][path]
        rows = {row["words"]: row["values"] for row in mine["rows"]}
        for row in card["rows"]:
            is_left_out = row["words"] == "N/N_Euler" or (row["words"] == LARGEST_STRESS and "section" not in mine)
            if not is_left_out and np.isfinite(row["values"]).all():
                is_force = any(kind in row["words"] for kind in ("force", "moment", "torque"))
                size = result.robot.length if row["words"].startswith("position") else force if is_force else None
                assert relative(rows[row["words"]], row["values"], size) < 1e-11
        for keys in [("axial",), ("T",), ("M_y", "M_z"), ("V_y", "V_z")] if "T" in card["lines"] else []:
            # two components as a magnitude: how far a rod between ball joints has turned about itself depends on the way
            sizes, wanted = (np.sqrt(sum(np.square(lines[key]) for key in keys)) for lines in (mine["lines"], card["lines"]))
            assert relative(sizes, wanted, force) < 1e-11
        if np.isfinite(card["lines"].get("stress", np.nan)).all() and "section" in mine:
            assert relative(mine["lines"]["stress"], card["lines"]["stress"]) < 1e-9
    for unit in ("displacement", "rotation"):
        assert {key: scene["units"][unit][key] for key in ("unit", "decimals")}.items() <= expected["units"][unit].items()
    assert [tuple(line) for line in scene["facts"][0][:-1]] == expected["facts"][0][:-1]


@pytest.mark.parametrize("name", ROBOTS)
def test_drawn_scene_equals_that_of_python(name):
    """Stations at rest, their twists by contribution, arrows and cards: at poses to which the platform was dragged."""
    robot, start = start_of(name)
    given = ks.analyze(start)
    size = describe_scene(given).size
    cases = random_cases(robot, start, 3, 0.5, seed=1)
    script = """machine.loads = { load: given.load, gravity: given.gravity, payload: given.payload };
      const { reason } = machine.move("platform", given.platform);
      return { reason, scene: sceneOf(machine, given.size) };"""
    compared = 0
    for case, answer in zip(cases, answers(given, [(script, {**case, "size": size}) for case in cases]), strict=True):
        if answer["reason"]:
            continue
        compared += 1
        compare_scenes(answer["scene"], by_python(robot, case, start))
    assert compared


def test_stresses_of_tapered_beams_are_left_out():
    """The page has no formula for them; numbers of the pose at which it was recorded would stand there at all poses."""
    description = package_robots.robot("five_bar").description
    name, other = [*description.beams][:2]
    stations = Tapered.of(Station(at, description.beams[name].section) for at in (0, 1))
    robot = ks.Robot(description.changed(name, section=stations))
    result = ks.analyze(robot.assemble(), [100, 0, -50, 0, 0, 0], payload=ks.Payload(2.0))
    (scene,) = answers(result, [("return sceneOf(machine, 1)", None)])
    words = {path: [row["words"] for row in card["rows"]] for path, card in scene["cards"].items()}
    assert LARGEST_STRESS not in words[f"beams/{name}"] and LARGEST_STRESS in words[f"beams/{other}"]
    assert scene["cards"][f"beams/{name}"]["lines"]["stress"] == [None]
    compare_scenes(scene, result)


VARIED = """const { sliders } = machine.data, counts = sliders.map(({ texts }) => texts.length);
  const reached = machine.vary(given.place.reduce((all, k, n) => all * counts[n] + k, 0));
  machine.loads = { load: given.load, gravity: given.gravity, payload: given.payload };
  const end = machine.move("platform", given.platform);
  return { reached, end, answer: machine.analyze(given), scene: sceneOf(machine, given.size) };"""


@pytest.mark.parametrize(
    "name", ["3rps", *(pytest.param(n, marks=pytest.mark.slow) for n in package_robots.NAMES if n != "3rps")]
)
def test_varied_robots_are_those_of_the_file(name):
    """All numbers and the scene, with other values of two arguments of the file, against the robot that is loaded with them."""
    robot, start = start_of(name)
    arguments = ParametricRobot(robot).arguments
    if name == "ur10" or not arguments:
        pytest.skip("its file has no arguments")
    names = np.random.default_rng(len(name)).choice(sorted(k for k in arguments if arguments[k]), 2, replace=False).tolist()
    vary = {key: [0.96 * arguments[key], 1.07 * arguments[key]] for key in names}
    variations = vary_result(ks.analyze(start), vary)
    cases = random_cases(robot, start, 9, 0.05 if name == "anymal_standing" else 0.3, seed=2)
    size = describe_scene(ks.analyze(start)).size
    places = list(itertools.product(*(range(len(slider.rows)) for slider in variations.sliders)))
    calls = [(VARIED, {**case, "place": place, "size": size}) for case, place in zip(cases, places, strict=True)]
    compared = 0
    for case, place, found in zip(cases, places, answers(ks.analyze(start), calls, vary=vary), strict=True):
        values = {slider.names[0]: slider.rows[k][0] for slider, k in zip(variations.sliders, place, strict=True)}
        other = ks.load_robot(robot.description.path, values)
        result = by_python(other, case)
        if not found["reached"] or found["end"]["reason"]:
            continue
        compared += 1
        assert found["answer"]["status"] == str(ks.Status(int(result.status)))
        for key, wanted in numbers_of(result).items():
            mine = found["answer"][key]
            assert relative(list(mine.values()) if isinstance(mine, dict) else mine, wanted) < 1e-11, key
        compare_scenes(found["scene"], result)
    assert compared > 4


TAPERED_ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="diameter" default="0.03"/><xacro:arg name="length" default="0.3"/>
  <link name="ground"/><link name="arm"/>
  <joint name="turn" type="continuous"><parent link="ground"/><child link="arm"/><axis xyz="0 1 0"/></joint>
  <joint name="clamp" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="$(arg length) 0 0"/></joint>
  <link name="tool"><inertial><mass value="2"/></inertial></link>
  <beam link="arm" from="turn" to="clamp" youngs_modulus="70e9" poisson_ratio="0.3" density="2700">
    <station at="0"><circle diameter="$(arg diameter)"/></station><station at="1"><circle diameter="0.02"/></station>
  </beam>
  <platform link="tool"/>
  <transmission name="motor"><joint name="turn"/></transmission>
</robot>"""


@pytest.mark.parametrize(
    ("name", "values"),
    [("diameter", [0.027, 0.03, 0.032]), pytest.param("length", [0.2, 0.3, 0.35], marks=pytest.mark.slow)],
)
def test_dimensions_of_tapered_beams_vary(name, values, tmp_path):
    (tmp_path / "arm.urdf.xacro").write_text(TAPERED_ARM)
    load, payload = [10, 5, -20, 1, 2, 3], ks.Payload(1.5, (0.05, 0.02, -0.03))

    def result_of(**values):
        robot = ks.load_robot(tmp_path / "arm.urdf.xacro", values)
        return ks.analyze(robot.assemble(actuators={"turn": 0.2}), load, payload=payload)

    script = "return { reached: machine.vary(given), answer: machine.analyze(), scene: sceneOf(machine, 0.3) }"
    calls = [(script, place) for place in range(3)]
    for value, found in zip(values, answers(result_of(), calls, vary={name: values}), strict=True):
        result = result_of(**{name: value})
        assert found["reached"]
        assert relative(found["answer"]["twist"], result.twist) < 1e-12
        assert relative(found["answer"]["stiffness"], result.stiffness) < 1e-12
        compare_scenes(found["scene"], result)


def test_loads_on_links_stay_where_they_are_given():
    """One in world axes at a point of the platform, one in the axes of a rod, at its end; also with two mechanisms of gravity."""
    robot = package_robots.robot("3rps")
    rod = robot.description.beams["rod_1"].link
    frame = robot.zero_frames
    end = robot.beams["rod_1"].ends(frame)[1][:, 0]
    link = robot.assemble().frame(rod)
    point = link[:3, :3].T @ (end - link[:3, 3])
    loads = {
        "platform": ks.LinkLoad([10, 20, -30, 1, 2, 3], (0.1, 0, 0)),
        rod: ks.LinkLoad([5, 0, 0, 0, 1, 0], tuple(point), "link"),
    }
    pose = robot.assemble(platform={"z": 0.55, "rx": 0.1, "ry": -0.05})
    for by_mechanism in (False, True):
        given = ks.analyze(robot.assemble(), loads=loads)
        script = """machine.move("platform", { z: 0.55, rx: 0.1, ry: -0.05 });
          return [machine.solved().values("twist"), sceneOf(machine, 1)];"""
        ((twist, scene),) = answers(given, [(script, None)], by_mechanism=by_mechanism)
        result = ks.analyze(pose, loads=loads)
        assert [tuple(line) for line in scene["facts"][0][:-1]] == describe_scene(result).facts.lines(0)[:-1]
        assert relative(twist, result.twist) < 1e-12
        shown = result.by_mechanism if by_mechanism else result
        K, s = len(scene["contributions"]), scene["readout"]
        parts = np.reshape(scene["stations"]["twist"], (-1, K, 6))[s]
        assert K == len(shown.contributions) + 1  # the payload that can be added
        found = dict(zip(scene["contributions"], parts, strict=True))
        assert relative(found[f"load on {rod}"], result.contributions[f"load on {rod}"], np.abs(twist).max()) < 1e-12
        assert ("limb_1: attached" in found) == by_mechanism


SCANNED, FINE = 24, 1e-4


def scan(robot, pose, kind, values):
    """Which poses (n,) of a line are good, as far as all before are: reached, within limits, on one side of singular poses.

    The actuators' singular poses are where the actuators' derivatives by the platform's coordinates have no inverse.
    """
    found = robot.assemble(**{kind: values}, near=pose, on_failure="nan")
    good = found.reached & ~found.limit_exceeded
    if kind == "platform":
        columns = []
        for name in values:
            before, after = (
                robot.assemble(platform={**values, name: values[name] + step}, near=found, on_failure="nan").actuators
                for step in (-1e-5, 1e-5)
            )
            columns.append([np.nan_to_num(after[drive] - before[drive]) for drive in robot.description.actuated])
        determinant = np.linalg.det(np.moveaxis(np.array(columns), 2, 0))
        good &= determinant * determinant[0] > 0
    return np.logical_and.accumulate(good)


@pytest.mark.parametrize(
    ("name", "kind", "spans", "why"),
    [
        ("five_bar", "platform", {"x": 0.8, "y": 0.8}, {"loops", "singular"}),
        ("five_bar", "actuators", {"shoulder_1": np.pi, "shoulder_2": np.pi}, {"limit", "loops"}),
        pytest.param("planar_3rrr", "platform", {"x": 1.0, "y": 1.0, "rz": np.pi}, {"limit", "singular"}, marks=pytest.mark.slow),
    ],
)
def test_lines_end_where_a_dense_scan_does(name, kind, spans, why):
    robot = package_robots.robot(name)
    pose = robot.assemble()
    present = {c: float((pose.platform if kind == "platform" else pose.actuators)[c]) for c in spans}
    pose = robot.assemble(**{kind: present}, near=pose)  # the page moves the coordinates from which a pose was assembled
    lines = [(c, sign * span) for c, span in spans.items() for sign in (-1, 1)]
    script = """const { kind, name, way } = given, here = machine.present(kind), { names } = machine.lines[kind];
      const target = here.map((value, k) => (names[k] === name ? value + way : value));
      return machine.lastOnLine(kind, machine.pose, target, 32);"""
    ends = answers(ks.analyze(pose), [(script, {"kind": kind, "name": c, "way": way}) for c, way in lines])
    reasons = set()
    for (coordinate, way), end in zip(lines, ends, strict=True):
        values = {c: np.full(SCANNED + 1, value) for c, value in present.items()}
        values[coordinate] = present[coordinate] + way * np.linspace(0, 1, SCANNED + 1)
        good = scan(robot, pose, kind, values)
        last = 1.0 if good.all() else (np.argmin(good) - 1) / SCANNED
        assert last - FINE <= end["part"] <= last + 1 / SCANNED + FINE, (coordinate, way, end)
        reasons.add(end["reason"])
        if end["reason"] == "limit":
            at = robot.assemble(
                **{kind: {**present, coordinate: present[coordinate] + (end["part"] + 2 * FINE) * way}}, near=pose
            )
            assert end["joint"]["name"] in at.limits_exceeded
            exceeded = at.limits_exceeded[end["joint"]["name"]]
            assert end["limit"] in (exceeded.lower, exceeded.upper)
    assert reasons == why


def test_limits_exceeded_at_the_start_end_no_line():
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 1.1, "rx": 0.0, "ry": 0.0})
    assert pose.limits_exceeded
    (end,) = answers(ks.analyze(pose), [("return machine.move('platform', { z: 0.8 })", None)])
    assert end["part"] == 1 and end["reason"] == ""


def test_the_platform_stops_at_a_limit_and_comes_back():
    robot = package_robots.robot("3rps")
    pose = robot.assemble(platform={"z": 0.5, "rx": 0.03, "ry": -0.17})
    script = """const first = machine.move("platform", { z: 5 }), rim = machine.closed(machine.pose);
      const second = machine.move("platform", { z: 0.5 });
      return { first, rim, second, z: machine.present("platform")[0] };"""
    (moved,) = answers(ks.analyze(pose), [(script, None)])
    z = moved["rim"]["platform"]["z"]
    assert moved["first"]["reason"] == "limit" and moved["first"]["joint"]["name"] == "prismatic_1" and not moved["rim"]["beyond"]
    beyond = robot.assemble(platform={"z": z + 2e-4, "rx": 0.03, "ry": -0.17}, near=pose)
    assert "prismatic_1" in beyond.limits_exceeded
    assert moved["second"]["reason"] == "" and moved["z"] == pytest.approx(0.5, abs=1e-15)


def test_unreachable_coordinates_and_wrong_names_are_told():
    robot = package_robots.robot("3rps")
    script = "try { return machine.analyze(given).status } catch (error) { return error.message }"
    calls = [
        {"platform": {"z": 5, "rx": 0, "ry": 0}},
        {"platform": {"z": 0.5}},
        {"platform": {"z": 0.5, "rx": 0, "ry": 0, "x": 0}},
    ]
    found = answers(ks.analyze(robot.assemble()), [(script, call) for call in calls])
    assert found == ["LIMIT_EXCEEDED", *["give platform coordinates z, rx, ry"] * 2]


def test_sliders_of_platform_coordinates_are_in_the_usual_order():
    for name, expected in (("delta", "x y z"), ("gough_stewart", "x y z rx ry rz"), ("spherical_3rrr", "rx ry rz")):
        assert determining_coordinates(package_robots.robot(name).assemble()) == tuple(expected.split())


def test_actuators_beyond_their_efforts_are_named_as_by_python():
    pose = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": 0.0})
    load = [0.0, 0.0, -6500.0, 0.0, 0.0, 0.0]
    (found,) = answers(ks.analyze(pose), [("return machine.analyze(given)", {"load": load})])
    wanted = [text for text in ks.analyze(pose, load).warnings if "limit of effort" in text]
    assert 0 < len(wanted) < 4 and [text for text in found["warnings"] if "limit of effort" in text] == wanted
