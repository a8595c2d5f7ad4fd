"""Optima against closed forms and brute force; catalogues, infeasible requirements, invalid arguments."""

import json
import warnings

import numpy as np
import package_robots
import parametric_machines
import pytest
from places import ROBOTS, ROOT

import kinetostatics as ks
from kinetostatics.design.problem import Evaluation
from kinetostatics.load_case import LoadCase
from kinetostatics.parametric.variables import read_variables

E, RHO = parametric_machines.E, parametric_machines.RHO
STILL = {"gravity": (0, 0, 0)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


@pytest.fixture(scope="module")
def cantilever(folder):
    return parametric_machines.cantilever(folder)


def test_lightest_cantilever_has_closed_form(cantilever, tmp_path):
    """d⁴ = 64 F L³ / (3 π E w), and the multiplier: the mass goes as w^(-1/2)."""
    best = ks.optimize(
        cantilever, {"diameter": "20mm:120mm"}, "mass", ["sag < 0.1 mm"], load=[0, 0, -500, 0, 0, 0], starts=2, **STILL
    )
    d = (64 * 500 * 0.8**3 / (3 * np.pi * E * 1e-4)) ** 0.25
    rod = RHO * np.pi * d**2 / 4 * 0.8
    assert best.feasible and best.parameters["diameter"] == pytest.approx(d, rel=1e-6)
    assert best.objective == pytest.approx(rod + 5, rel=1e-6)
    assert best.no_influence == () and best.active[0].text == "sag < 0.1 mm"
    assert best.active[0].saving == pytest.approx(0.005 * rod, rel=1e-3)
    assert all(start.objective == pytest.approx(best.objective, rel=1e-6) for start in best.starts)
    text = str(best)
    assert "feasible, mass" in text and "is active" in text and "2 of 2 searches" in text and "Optimum" in repr(best)
    assert json.loads(json.dumps(best.to_dict()))["units"] == {"diameter": "m"}
    best.save(tmp_path / "sized.urdf")
    saved = ks.load_robot(tmp_path / "sized.urdf")
    assert -ks.analyze(saved.assemble(), [0, 0, -500, 0, 0, 0], **STILL).twist[2] == pytest.approx(1e-4, rel=1e-6)


def test_plain_urdf_is_sized_by_part_dimensions(cantilever, folder, tmp_path):
    """The rod's own diameter has the closed form of the file's argument, also in the saved file."""
    plain = folder / "plain.urdf"
    ks.save_robot(ks.load_robot(cantilever), plain)
    loaded = {"load": [0, 0, -500, 0, 0, 0], "starts": 1, **STILL}
    best = ks.optimize(plain, {"rod.outer_diameter": "20mm:120mm"}, "mass", ["sag < 0.1 mm"], **loaded)
    d = (64 * 500 * 0.8**3 / (3 * np.pi * E * 1e-4)) ** 0.25
    assert best.parameters["rod.outer_diameter"] == pytest.approx(d, rel=1e-6) and best.units["rod.outer_diameter"] == "m"
    assert best.before == pytest.approx(RHO * np.pi * 0.04**2 / 4 * 0.8 + 5, rel=1e-9)
    best.save(tmp_path / "sized.urdf")
    saved = ks.load_robot(tmp_path / "sized.urdf")
    assert saved.description.beams["rod"].section.outer_diameter == pytest.approx(d, rel=1e-6)
    assert -ks.analyze(saved.assemble(), loaded["load"], **STILL).twist[2] == pytest.approx(1e-4, rel=1e-6)
    both = ("rod.outer_diameter", "rod.inner_diameter")
    with pytest.raises(ks.ArgumentError, match=r"has no parameter 'rod.inner_diameter'"):
        ks.optimize(plain, {both: "standard_tubes"}, "mass", ["sag < 0.1 mm"], **loaded)


def test_lightest_feasible_catalogue_tube_is_chosen_for_a_part(cantilever, folder):
    """Its hole follows from its wall; beside it an argument of the file varies."""
    text = cantilever.read_text(encoding="utf-8").replace("<circle diameter=", '<tube inner_diameter="0.03" outer_diameter=')
    (folder / "tube.urdf.xacro").write_text(text, encoding="utf-8")
    tubes = np.array([[40, 4], [60, 2], [60, 8], [70, 3], [70, 10], [100, 3], [100, 20]])
    np.savetxt(folder / "tubes.csv", tubes, "%g", ",", header="outer_diameter [mm],wall [mm]", comments="")
    both, loaded = ("rod.outer_diameter", "rod.inner_diameter"), {"load": [0, 0, -500, 0, 0, 0], **STILL}
    vary = {both: str(folder / "tubes.csv"), "length": "0.7,0.8"}
    best = ks.optimize(folder / "tube.urdf.xacro", vary, "mass", ["sag < 0.1 mm"], **loaded)
    outer, inner = 1e-3 * tubes[:, 0], 1e-3 * (tubes[:, 0] - 2 * tubes[:, 1])
    stiff = outer**4 - inner**4 >= 64 * 500 * 0.7**3 / (3 * np.pi * E * 1e-4)
    k = int(np.argmin(np.where(stiff, outer**2 - inner**2, np.inf)))
    assert best.feasible and 0 < stiff.sum() < len(tubes) and best.parameters["length"] == 0.7
    assert [best.parameters[name] for name in both] == pytest.approx([outer[k], inner[k]], rel=1e-12)
    assert best.objective == pytest.approx(RHO * np.pi / 4 * (outer[k] ** 2 - inner[k] ** 2) * 0.7 + 5, rel=1e-9)


@pytest.mark.slow
def test_dimensions_of_one_pattern_stay_equal():
    """All three rods of the tripod keep one size, and its mass is that for the file's argument."""
    over, limit = {"z": 0.55, "rx": 0.0, "ry": 0.0}, ["deflection_any_direction(500 N) < 20um"]
    alike = ks.optimize("3rps", {"rod_*.outer_diameter": "80mm:120mm"}, "mass", limit, over, starts=1)
    robot = package_robots.robot("3rps", rod_diameter=alike.parameters["rod_*.outer_diameter"])
    result = ks.analyze(robot.assemble(platform=over))
    assert 500 * np.linalg.eigvalsh(result.compliance[:3, :3])[-1] == pytest.approx(20e-6, rel=1e-6)
    assert result.base_wrench[2] / 9.81 == pytest.approx(alike.objective, rel=1e-9)
    assert len({beam.section.outer_diameter for beam in alike.robot.description.beams.values()}) == 1
    for wrong, words in (
        (
            {"rod_*.outer_diametre": "40mm:120mm"},
            r"has no parameter 'rod_\*.outer_diametre': did you mean 'rod_.\.outer_diameter'",
        ),
        ({"rod_*.outer_diameter": "40kg:120kg"}, r"is given in kg, but it is in m"),
        ({"rod_*.poisson_ratio": "1mm:2mm"}, r"is given in mm, but it has no unit"),
        ({"rod_*.*": "40mm:120mm"}, r"stands for numbers in several units, "),
        (
            {"rod_*.outer_diameter": "40mm:120mm", "rod_1.outer_diameter": "1mm:2mm"},
            r"vary: 'rod_1.outer_diameter' is named twice, the second time by 'rod_1.outer_diameter'",
        ),
    ):
        with pytest.raises(ks.ArgumentError, match=words):
            ks.optimize("3rps", wrong)


@pytest.mark.slow
def test_two_bar_truss_has_closed_form(folder):
    """Stress σ: A = F √(r² + h²) / (2 h σ), mass 2 ρ A √(r² + h²) is least at h = r: 2 ρ F r / σ."""
    path = parametric_machines.pinned_truss(folder, [(1, 0), (-1, 0)])
    best = ks.optimize(
        path,
        {"diameter": "10mm:40mm", "height": "0.25m:0.8m"},
        "mass",
        ["stress < 50 MPa"],
        load=[0, 0, -20e3, 0, 0, 0],
        starts=1,
        **STILL,
    )
    assert best.feasible and best.objective == pytest.approx(2 * RHO * 20e3 * 0.4 / 50e6, rel=1e-6)
    assert best.parameters["height"] == pytest.approx(0.4, rel=1e-3)  # the mass is flat there
    # mass goes as 1/σ
    assert best.active[0].saving == pytest.approx(0.01 * best.objective, rel=1e-3)


def test_infeasible_requirements_are_reported(cantilever):
    best = ks.optimize(
        cantilever,
        {"diameter": "20mm:60mm"},
        "mass",
        ["sag < 1um", "mass < 30 kg"],
        load=[0, 0, -500, 0, 0, 0],
        starts=1,
        **STILL,
    )
    assert not best.feasible and "NOT feasible" in str(best) and "is violated" in str(best)
    assert best.parameters["diameter"] == pytest.approx(0.06, rel=1e-3)  # the least violation
    assert min(item.margin for item in best.requirements) < -1


ARM = """<robot name="arm"><link name="base"/><link name="upper"/><link name="fore"/>
<link name="tool"><inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="flange" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0.4 0 0"/></joint><platform link="tool"/>
<transmission name="s"><joint name="shoulder"/></transmission><transmission name="e"><joint name="elbow"/></transmission>
<beam link="upper" youngs_modulus="70e9" poisson_ratio="0.33" density="2700">
<tube outer_diameter="0.08" inner_diameter="0.07"/></beam>
<beam link="fore" youngs_modulus="70e9" poisson_ratio="0.33" density="2700">
<tube outer_diameter="0.06" inner_diameter="0.05"/></beam>
<joint_stiffness joint="shoulder" drive="2e4"/><joint_stiffness joint="elbow" drive="1e4"/></robot>"""


def test_best_infeasible_design_is_not_worse_than_the_start(tmp_path):
    """A thin wall bends, a thick one is too heavy for the actuators; at the lower bound there is hardly a wall."""
    file = tmp_path / "arm.urdf"
    file.write_text(ARM, encoding="utf-8")
    robot = ks.load_robot(file)
    best = ks.optimize(file, {"fore.outer_diameter": "50mm:90mm"}, "mass", ["sag < 1.5mm"], starts=1)
    section = robot.description.beams["fore"].section
    tried = [ks.Robot(robot.description.changed("fore", section=section.of(d, 0.05))) for d in (0.051, 0.052, 0.053, 0.06, 0.08)]
    sags = [float(np.linalg.norm(ks.analyze(one.assemble()).twist[:3])) for one in tried]
    assert not best.feasible and 1.5e-3 < best.requirements[0].worst < min(sags)
    with pytest.raises(ks.ArgumentError, match=r"no actuator that slides; its actuators turn: actuator_torque$"):
        ks.optimize(file, {"fore.outer_diameter": "55mm:90mm"}, "mass", ["actuator_force < 1kN"], starts=1)


def test_best_value_of_lists_and_catalogues_is_chosen(cantilever, tmp_path):
    load = {"load": [0, 0, -500, 0, 0, 0], **STILL}
    exact = (64 * 500 * 0.8**3 / (3 * np.pi * E * 1e-4)) ** 0.25
    assert 0.095 < exact < 0.1
    best = ks.optimize(cantilever, {"diameter": "standard_bars"}, "mass", ["sag < 0.1mm"], **load)
    assert best.parameters["diameter"] == 0.1 and "all 35 combinations" in best.searched
    best = ks.optimize(
        cantilever, {"diameter": [0.08, 0.09, 0.1], "length": "0.7m:1m"}, "mass", ["sag < 0.1mm"], starts=1, **load
    )
    assert best.feasible and best.parameters == pytest.approx({"diameter": 0.09, "length": 0.7})
    assert best.at_bounds == ("length at its lower bound",)
    (tmp_path / "sizes.csv").write_text("bar,length [mm],diameter [mm]\n1,900,110\n2,800,100\n3,800,95\n", encoding="utf-8")
    best = ks.optimize(cantilever, {("diameter", "length"): str(tmp_path / "sizes.csv")}, "mass", ["sag < 0.1mm"], **load)
    assert best.parameters == {"diameter": 0.1, "length": 0.8}


@pytest.mark.parametrize(
    ("titles", "said"),
    [
        ("outer_diameter [mm],wall [mm]", ""),
        ("wall [mm],diameter [mm]", ""),  # in any order
        ("rod_inner_diameter [mm],rod_outer_diameter [mm]", ""),
        ("OD [mm],wall thickness [mm]", "the titles OD, wall thickness do not determine the column of 'outer_diameter'"),
        ("outer_diameter [mm],wall thickness [mm]", "do not determine the column of 'inner_diameter': give it this title"),
        ("outer_diameter [mm],tube_diameter [mm],wall [mm]", ""),  # the parameter's own name comes first
        ("rod_diameter [mm],tube_diameter [mm],wall [mm]", "do not determine the column of 'outer_diameter'"),
    ],
)
def test_catalogue_columns_are_assigned_by_their_titles(tmp_path, titles, said):
    """A tube of 40 × 2 mm has a bore of 36 mm: the wall is never taken for it."""
    cells = [40 if "OD" in title or ("diameter" in title and "inner" not in title) else 2 for title in titles.split(",")]
    cells = [36 if "inner" in title else cell for title, cell in zip(titles.split(","), cells, strict=True)]
    rows = "\n".join(",".join(str(cell + more) for cell in cells) for more in (0, 0.5))
    (tmp_path / "tubes.csv").write_text(f"{titles}\n{rows}\n", encoding="utf-8")
    vary = {("rod.outer_diameter", "rod.inner_diameter"): str(tmp_path / "tubes.csv")}
    if said:
        with pytest.raises(ks.ArgumentError, match=said):
            read_variables(vary)
    else:
        _, (choice,) = read_variables(vary)
        assert choice.rows[0] == pytest.approx((0.04, 0.036))


def test_every_load_acts_at_every_pose():
    """All pairs of two poses and three loads: the worst values are those of single analyses."""
    over = {"z": [0.5, 0.6], "rx": 0.1, "ry": 0.0}
    loads = [[0, 0, -100, 0, 0, 0], [300, 0, 0, 0, 20, 0], [0, 50, 0, 0, 0, 0]]
    limits = ["sag < 1mm", "mass < 300kg", "actuator_force < 1MN", "stress < 1GPa"]
    best = ks.optimize("3rps", {"rod_diameter": "60mm,80mm"}, "mass", limits, over, load=loads)
    robot = ks.load_robot("3rps", parameters={"rod_diameter": best.parameters["rod_diameter"]})
    sags, forces, stresses = {}, [], []
    for z in over["z"]:
        for k, load in enumerate(loads):
            result = ks.analyze(robot.assemble(platform={**over, "z": z}), load)
            sags[z, k] = np.linalg.norm(result.twist[:3])
            forces += [abs(float(force)) for force in result.actuator_forces.values()]
            stresses += [float(beam.stress) for beam in result.beams.values()]
    (z, k), worst = max(sags.items(), key=lambda item: item[1])
    sag, mass, force, stress = best.requirements
    assert (force.worst, stress.worst) == pytest.approx((max(forces), max(stresses)), rel=1e-9)  # of all actuators and beams
    assert best.feasible and best.poses == 2 and best.result.shape == (2, 3) and k == 1
    assert sag.worst == pytest.approx(worst, rel=1e-9) and sag.pose["z"] == z and sag.case == (k,)
    assert mass.worst == pytest.approx(best.objective) and f"z = {z}, rx = 0.1, ry = 0, load[1]" in str(best)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("vary", "bound"), [({"length": "0.7:1.0"}, "length at its lower bound"), ({"E": "1e11:2.2e11"}, "E at its upper bound")]
)
def test_saving_by_a_looser_limit_with_parameters_at_bounds(cantilever, vary, bound):
    """The rod's mass goes as w^(-1/2) for any length and modulus, which are at a bound."""
    load = {"load": [0, 0, -500, 0, 0, 0], **STILL}
    best = ks.optimize(cantilever, {"diameter": "20mm:120mm", **vary}, "mass", ["sag < 0.1 mm"], starts=1, **load)
    assert best.at_bounds == (bound,)
    assert best.active[0].saving == pytest.approx(0.005 * (best.objective - 5), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"vary": {"diameter": "9mm:2mm"}}, "from a smaller to a larger"),
        ({"vary": 3}, "must be a mapping"),
        ({"vary": {3: "9mm,12mm"}}, "vary has the key 3"),
        ({"minimize": "weight"}, "no quantity 'weight'"),
        ({"vary": {"diameter": "9mm"}}, "two different values"),
        (
            {"vary": {"diameter": [*range(1, 51)], "length": [*range(1, 52)]}},
            "the lists have 2,550 combinations, more than 2,000",
        ),
        ({"vary": {"diameter": "4cm:8kg"}}, r"vary: diameter is given in kg, but it is in m"),
        ({"vary": {"diameter": "1mm..2mm"}}, "is not a number; a range is written 20mm:120mm, values 20mm,25mm$"),
        ({"vary": {("diameter", "length"): "9mm:12mm"}}, "rows of a catalogue"),
        ({"vary": {"diameter": "9mm:12mm", ("diameter", "wall"): "standard_tubes"}}, "varied twice"),
        ({"minimize": "least_rotational_stiffness"}, "is not to be minimized"),
        ({"subject_to": "sag < 1um"}, "a list of requirements"),
        ({"subject_to": ["sag = 1um"]}, "is not of the form"),
        ({"subject_to": ["sag < 0"]}, "greater than zero"),
        ({"subject_to": ["sag(3 N) < 1um"]}, "write sag"),
        ({"subject_to": ["deflection_any_direction < 1um"]}, "in the brackets"),
        ({"subject_to": ["actuator_force < 1kN"]}, "has no actuator that slides$"),
        ({"minimize": ["sag < 1mm"]}, "requirements are given by subject_to"),
    ],
)
def test_invalid_arguments_are_refused(cantilever, changes, said):
    given = {"vary": {"diameter": "20mm:60mm"}, "minimize": "mass", "subject_to": ["sag < 1mm"], **changes}
    with pytest.raises(ks.ArgumentError, match=said):
        ks.optimize(cantilever, **given)


def test_closure_tolerance_admits_small_loop_gaps(tmp_path):
    """Two parallel tubes that miss one another by a micrometre: 3 constraints too many hold the gap open."""
    text = (
        (ROOT / "docs" / "start" / "your_own_robot.md").read_text(encoding="utf-8").partition("```xml\n")[2].partition("```")[0]
    )
    boom, meeting = tmp_path / "boom.urdf.xacro", '<successor link="head"><origin xyz="0 0 0.2"/>'
    assert meeting in text
    boom.write_text(text.replace(meeting, meeting.replace("0 0 0.2", "0 1e-6 0.2")), encoding="utf-8")
    off = {"diameter": [0.08, 0.1]}
    assert not ks.optimize(boom, off, actuators={"motor": 0.1}).feasible
    best = ks.optimize(boom, off, actuators={"motor": 0.1}, closure_tolerance=1e-5)
    assert best.feasible and best.parameters["diameter"] == 0.08


def test_lengths_in_millimetres_cause_a_warning(cantilever):
    """Lengths far from the file's own and without a unit; moduli and lengths with a unit cause none."""
    from kinetostatics.design.optimize import prepare

    def prepared(vary, subject_to=(), robot=cantilever):
        links = {"platform_link": None, "base_link": None}
        return prepare(robot, vary, "mass", subject_to, (None, None), None, None, links, 1, None, 1e-10, LoadCase(**STILL))

    with pytest.warns(UserWarning, match=r"diameter from 10 m is 250 times the file's own 0\.04 m: .* write 0\.01 for 10 mm"):
        prepared({"diameter": "10:40"})
    with pytest.warns(UserWarning, match="diameter from 20 m is 500 times"):
        prepared({"diameter": [20, 25]})
    with pytest.warns(UserWarning, match=r"^sag < 20 allows 20 m, .* times the robot's size of .*; write 0\.02 for 20 mm"):
        prepared({"rod_diameter": "4cm:5cm"}, ["sag < 20", "stress < 200", "rotation < 20"], ROBOTS / "3rps.urdf.xacro")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for vary in (
            {"diameter": "10m:40m"},
            {"E": "7e12:9e12"},
            {"density": (10 * 7850.0, 50 * 7850.0)},
            {"diameter": (0.02, 2.0)},
        ):
            prepared(vary)


def test_parameters_without_influence_are_reported():
    """Limits of joints play no part in mass and sag."""
    best = ks.optimize(ROBOTS / "3rps.urdf.xacro", {"rod_length_max": "0.9m:1.2m"}, "mass", ["sag < 1mm"], starts=1)
    assert best.no_influence == ("rod_length_max",) and best.at_bounds == () and best.evaluations < 10
    assert "rod_length_max has no influence on objective or requirements" in " ".join(str(best).split())
    assert best.to_dict()["no_influence"] == ["rod_length_max"]


@pytest.mark.parametrize(("above", "active"), [(3e-3, False), (3e-5, False), (2e-6, True)])
def test_requirement_is_active_at_its_limit_only(tmp_path, above, active):
    """A rod of 60 mm meets the limit of the sag; the stress 32 F L / (π d³) has its own a little above."""
    length, force, d = 0.8, 500.0, 0.06
    sag, stress = 64 * force * length**3 / (3 * np.pi * parametric_machines.E * d**4), 32 * force * length / (np.pi * d**3)
    limits = [f"sag < {sag!r} m", f"stress < {stress * (1 + above)!r} Pa"]
    rod, load = parametric_machines.cantilever(tmp_path), [0, 0, -force, 0, 0, 0]
    found = ks.optimize(rod, {"diameter": "20mm:120mm"}, "mass", limits, load=load, gravity=(0, 0, 0), starts=1)
    assert [item.active for item in found.requirements] == [True, active]
    assert found.requirements[1].margin == pytest.approx(above, rel=0.01)


@pytest.mark.parametrize("place", [5e-4, 0.3, 1 - 5e-4])
def test_saving_near_a_bound_is_that_of_the_requirement(tmp_path, place):
    """The rod's mass goes as the sag to the power −1/2: 1 % more sag saves half a percent, unless the bound itself is reached."""
    length, force, d = 0.8, 500.0, 0.02 * 6**place
    sag = 64 * force * length**3 / (3 * np.pi * parametric_machines.E * d**4)
    rod, load = parametric_machines.cantilever(tmp_path), [0, 0, -force, 0, 0, 0]
    found = ks.optimize(rod, {"diameter": "20mm:120mm"}, "mass", [f"sag < {sag!r} m"], load=load, gravity=(0, 0, 0), starts=1)
    assert found.parameters["diameter"] == pytest.approx(d, rel=1e-6) and not found.at_bounds
    assert found.requirements[0].saving == pytest.approx(0.005 * 7850 * length * np.pi / 4 * d**2, rel=0.01)


def test_violations_up_to_a_millionth_of_the_limit_count_as_rounding():
    result = ks.analyze(package_robots.robot("3rps").assemble())
    assert Evaluation(1.0, np.array([0.2, -0.9e-6]), result, []).feasible
    assert not Evaluation(1.0, np.array([0.2, -1.1e-6]), result, []).feasible
    assert not Evaluation(1.0, np.array([0.2]), None, []).feasible
