"""Facts of poses (beyond limits, indeterminate, …): each is flagged whatever the others are, and maps are masked by them."""

import importlib

import numpy as np
import package_robots
import pytest
import xarray as xr
from places import CASES

import kinetostatics as ks
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.reports.map import map_report
from kinetostatics.status import FACTS

S = np.linspace(-0.3, 0.3, 7)
BEYOND = np.abs(S) > 0.1 + 1e-9


def two_rigid():
    """A slide on two rigid rails, of 0.1 m to both sides."""
    return ks.load_robot(CASES / "two_rigid.urdf")


@pytest.fixture(scope="module")
def far():
    """The slide swept to three times its limits."""
    return ks.sweep(two_rigid(), actuators={"s": S})


# ---- results ---------------------------------------------------------------------------------------------------------


def test_limit_exceeded_is_flagged_beside_indeterminate_forces():
    result = ks.analyze(two_rigid().assemble(actuators={"s": S}))
    assert np.all(result.status == ks.Status.INDETERMINATE) and np.all(result.indeterminate)
    assert np.all(np.isnan(result.limbs["limb_1"].stiffness))
    np.testing.assert_array_equal(result.limit_exceeded, BEYOND)
    np.testing.assert_array_equal(result.configuration.limit_exceeded, BEYOND)
    assert not result.basis_degenerate.any()
    assert set(result.facts) == set(FACTS)
    for where in result.facts.values():
        assert where.dtype == bool and not where.flags.writeable
    loads = ks.analyze(two_rigid().assemble(actuators={"s": S}), load=np.zeros((2, 1, 6)))
    np.testing.assert_array_equal(loads.limit_exceeded, [BEYOND] * 2)
    one = ks.analyze(two_rigid().assemble(actuators={"s": 0.3}))
    assert one.limit_exceeded.shape == () and one.limit_exceeded and one.indeterminate
    assert isinstance(one.configuration.limit_exceeded, np.ndarray)


def test_reports_name_every_fact():
    words = str(ks.analyze(two_rigid().assemble(actuators={"s": 0.3})))
    head = words[: words.index("\n\n")].splitlines()
    assert head[0].startswith("Analysis of 'two_rigid': INDETERMINATE, LIMIT_EXCEEDED; ")
    assert head[1].startswith("  INDETERMINATE, ") and head[2].startswith("  LIMIT_EXCEEDED, ")
    inside = str(ks.analyze(two_rigid().assemble()))
    assert "LIMIT_EXCEEDED" not in inside and inside.count("INDETERMINATE") == 2
    batch = str(ks.analyze(two_rigid().assemble(actuators={"s": S})))
    rows = {line.split()[0]: line.split()[1] for line in batch.splitlines() if line.startswith("  ") and "_" not in line[:2]}
    assert (rows["INDETERMINATE"], rows["LIMIT_EXCEEDED"], rows["4"]) == ("7", "4", "of")
    assert "OK" not in rows


def test_singular_pose_beyond_a_limit_has_both_flags():
    """An actuator that does not hold what it carries: the platform swings freely about the other joint."""
    text = (CASES / "two_rigid.urdf").read_text()
    text = text[: text.index("<loop")] + text[text.index("</loop>") + 7 :]
    text = text.replace(
        '<platform link="p"/>',
        '<joint name="f" type="revolute"><parent link="p"/><child link="q"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><link name="q"/><platform link="q"/>',
    )
    one = ks.analyze(ks.Robot(parse_robot_text(text)).assemble(actuators={"s": [0.0, 0.3]}), on_failure="nan")
    assert np.all(one.status == ks.Status.SINGULAR)
    np.testing.assert_array_equal(one.limit_exceeded, [False, True])
    assert not one.indeterminate.any()


def test_unreached_pose_has_no_facts():
    robot = package_robots.robot("orthoglide")
    result = ks.analyze(robot.assemble(platform={"x": [0.0, 9.0], "y": 0.0, "z": 0.0}))
    assert result.status.tolist() == [ks.Status.OK, ks.Status.UNREACHABLE]
    assert not any(where.any() for where in result.facts.values())


# ---- maps ------------------------------------------------------------------------------------------------------------


def test_map_poses_beyond_limits_are_invalid(far):
    assert far["limit_exceeded"].dtype == bool
    np.testing.assert_array_equal(far["limit_exceeded"], BEYOND)
    np.testing.assert_array_equal(far["indeterminate"], True)
    np.testing.assert_array_equal(ks.indices.valid(far), ~BEYOND)
    assert np.all(ks.indices.valid(far, beyond_limits=True))
    at = ks.sweep(two_rigid(), actuators={"s": [-0.3, 0.2, 0.3]})
    with pytest.raises(ks.ArgumentError, match="no pose of the map is valid and within the joints' limits"):
        ks.indices.best(at, "linear_sag")
    assert ks.indices.best(at, "linear_sag", beyond_limits=True).facts == ("limit_exceeded", "indeterminate")
    assert ks.indices.best(far, "linear_sag").facts == ("indeterminate",)


def test_a_summary_counts_every_fact(far):
    words = str(map_report(far))
    assert "\n           4 beyond a joint's limit\n           7 with undetermined forces\n" in words
    assert "\n           4 of them counted more than once\n" in words
    assert "no pose is within the joints' limits" in str(map_report(far.isel(s=[0, 6])))


def test_figures_mask_poses_beyond_limits(far):
    from kinetostatics.plot.masks import masks_of
    from kinetostatics.plot.selection import select

    shown = select(far, "linear_sag", ["s"], {}, False)
    assert [(mask.label, mask.where.tolist()) for mask in masks_of(shown.values, shown.status)] == [
        ("beyond joint limits", BEYOND.tolist())
    ]
    lost = select(far, "intensity:limb_2: force along limb axis at its outer end", ["s"], {}, True)
    assert [mask.label for mask in masks_of(lost.values, lost.status)] == ["not determined"]
    part = select(far, "intensity:limb_2: force along limb axis at its outer end", ["s"], {}, False)
    masks = {mask.label: mask.where for mask in masks_of(part.values, part.status)}
    np.testing.assert_array_equal(masks["beyond joint limits"], BEYOND)
    np.testing.assert_array_equal(masks["not determined"], ~BEYOND)


# ---- check -----------------------------------------------------------------------------------------------------------


def test_older_maps_lack_facts_without_a_status(monkeypatch):
    facts = importlib.import_module("kinetostatics.status")
    older = xr.Dataset({"status": ("s", np.array([0, 1, 2], dtype=np.int8))})
    assert facts.in_map(older, "limit_exceeded").values.tolist() == [False, True, False]
    monkeypatch.setattr(facts, "FACTS", {"new": facts.Fact("new", None, "", "")})
    assert not facts.in_map(older, "new").any()


def test_map_poses_out_of_reach_are_invalid_though_within_all_limits():
    ds = ks.sweep("orthoglide", platform={"x": [0.0, 9.0], "y": 0.0, "z": 0.0})
    assert ds["limit_exceeded"].values.ravel().tolist() == [False, False]
    assert ks.indices.valid(ds).values.ravel().tolist() == [True, False]
    assert ks.indices.valid(ds, beyond_limits=True).values.ravel().tolist() == [True, False]
