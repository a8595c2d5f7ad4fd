"""The table of small errors of manufacture: every row is what analyze says of that error alone."""

import numpy as np
import package_robots
import pytest
from simple_machines import mount, springs, two_columns

import kinetostatics as ks

STILL = (0, 0, 0)


@pytest.mark.smoke
def test_the_table_of_tolerances():
    machine = two_columns()
    pose = machine.assemble()
    table = ks.tolerances(pose, length=2e-4, temperature=30, by="displacement")
    assert {row.kind for row in table} == {"joint", "beam"} and table.ranked_by == "displacement"
    sizes = [row.displacement for row in table]
    assert sizes == pytest.approx(sorted(sizes, reverse=True), rel=1e-6)  # equals stand in the file's order
    assert len(table) == len({(row.name, row.error) for row in table}) == 4 * 6 + 2 * 2
    for row in table:
        amount = {"length": {"length": 2e-4}, "temperature": {"temperature": 30}}.get(row.error)
        if amount is None:
            twist = np.zeros(6)
            twist[("x", "y", "z", "rx", "ry", "rz").index(row.error)] = row.amount
            amount = {"twist": twist, "frame": "joint"}
        one = ks.analyze(pose, gravity=STILL, assembly_errors={row.name: amount})
        np.testing.assert_allclose(row.twist, one.twist, rtol=1e-9, atol=1e-15)
        forces = {name: np.linalg.norm(wrench[:3]) for name, wrench in one.joint_wrenches.items()}
        assert row.force == pytest.approx(max(forces.values()), rel=1e-6, abs=1e-4)
    text = str(ks.tolerances(pose))
    assert "ranked by the force" in text and "foot_a" in text and "temperature" in text
    amounts = {"x": 1e-4, "length": 1e-4, "rx": 1e-3, "temperature": 1.0}  # without others
    assert {row.error: row.amount for row in ks.tolerances(pose) if row.error in amounts} == amounts


def test_errors_at_the_tip_of_a_tool():
    """The tip moves by what o does and by the turn on its arm; the forces are the same."""
    pose, tool = package_robots.robot("3rps").assemble(platform={"z": 0.5, "rx": 0.1, "ry": -0.05}), (0.05, 0, 0.2)
    of_o, of_tip = ks.tolerances(pose, by="rotation"), ks.tolerances(pose, by="rotation", tool=tool)
    arm = pose.platform_frame[:3, :3] @ tool
    assert len(of_o) == len(of_tip) and any(row.rotation > 1e-4 for row in of_tip)
    for one, other in zip(of_o, of_tip, strict=True):
        shift = np.add(one.twist[:3], np.cross(one.twist[3:], arm))
        np.testing.assert_allclose(other.twist, [*shift, *one.twist[3:]], atol=1e-15)
        assert other.displacement == pytest.approx(np.linalg.norm(shift), abs=1e-15) and other.force == one.force
    assert "moves the tool's tip" in str(of_tip) and "it moves the tool's tip by" in repr(of_tip)
    assert of_tip.to_dict()["tool"] == [0.05, 0, 0.2] and "tool" not in of_o.to_dict()


@pytest.mark.parametrize("platform", [None, {"z": 0.5, "rx": 0.1, "ry": -0.05}])
def test_a_determinate_robot_locks_in_no_force(platform):
    table = ks.tolerances(package_robots.robot("3rps").assemble(platform=platform))
    assert table.ranked_by == "displacement" and all(row.force == 0 and row.at == "" for row in table)
    assert "not overconstrained" in str(table)
    # errors along a joint's own freedoms do nothing: a spherical joint's rotations are not in the table
    assert {row.error for row in table if row.name.startswith("spherical")} <= {"x", "y", "z"}


def test_tolerances_tell_the_largest_moment_and_all_of_the_motion():
    """A column too long between two clamps bends both; the moment of the table is that of the joint which has the largest."""
    pose = two_columns().assemble()
    for row in ks.tolerances(pose, length=2e-4, angle=1e-3, temperature=30):
        if row.kind != "joint":
            continue
        twist = np.zeros(6)
        twist[("x", "y", "z", "rx", "ry", "rz").index(row.error)] = row.amount
        one = ks.analyze(pose, gravity=STILL, assembly_errors={row.name: {"twist": twist, "frame": "joint"}})
        moments = {name: np.linalg.norm(wrench[3:]) for name, wrench in one.joint_wrenches.items()}
        forces = {name: np.linalg.norm(wrench[:3]) for name, wrench in one.joint_wrenches.items()}
        assert row.moment == pytest.approx(max(moments.values()), rel=1e-6, abs=1e-4)
        assert row.force == pytest.approx(forces[row.at] if row.at else 0.0, rel=1e-6, abs=1e-4)
        assert row.displacement == pytest.approx(np.linalg.norm(one.twist[:3]), rel=1e-9, abs=1e-15)
        assert row.rotation == pytest.approx(np.linalg.norm(one.twist[3:]), rel=1e-9, abs=1e-15)


def test_an_error_without_effect_is_not_in_the_table():
    """A joint that is springs everywhere: every error moves the platform; beside turns shifts of 1e-12 m are nothing."""
    pose = mount(springs("mount", linear="1e5 1e5 1e5", angular="1e4 1e4 1e4")).assemble()
    assert len(ks.tolerances(pose, length=1e-8, angle=0.2)) == 6
    assert {row.error for row in ks.tolerances(pose, length=1e-11, angle=0.2)} == {"rx", "ry", "rz"}


def test_which_forces_are_rounding_does_not_depend_on_how_large_errors_are():
    """All is linear: errors that lock in moments alone do so whatever their size, beside moments of any size."""
    pose = package_robots.robot("tripteron").assemble()

    def told(size):
        rows = ks.tolerances(pose, 1e-4 * size, 1e-3 * size).rows
        return {(row.name, row.error): (row.force / size, row.moment / size) for row in rows}

    own = told(1.0)
    assert sum(force == 0 < moment for force, moment in own.values()) == 24
    with pytest.warns(UserWarning):
        other = told(1e8)
    for name, (force, moment) in told(1e-8).items() | other.items():
        assert (force, moment) == pytest.approx(own[name], rel=1e-6) and (force == 0) == (own[name][0] == 0)


def test_forces_that_rigid_parts_leave_open_do_not_count():
    """Two rigid bars of a parallelogram share in a way that nobody knows; what errors lock into the other bars is told."""
    description = package_robots.robot("orthoglide").description
    for name in ("bar_1b", "bar_2b", "bar_3a", "bar_3b"):
        description = description.without_beam(name)
    pose = ks.Robot(description).assemble()
    (row, *_) = table = ks.tolerances(pose)
    assert all(np.all(np.isfinite([row.force, row.moment, *row.twist])) for row in table)
    one = ks.analyze(pose, gravity=STILL, assembly_errors={row.name: {"twist": [row.amount, 0, 0, 0, 0, 0], "frame": "joint"}})
    forces = [np.linalg.norm(wrench[:3]) for wrench in one.joint_wrenches.values()]
    assert np.any(np.isnan(forces)) and row.error == "x" and row.force == pytest.approx(np.nanmax(forces), rel=1e-6)
