"""``kinetostatics check`` of every robot in ``robots/`` and of the odd ones of ``odd_robots.py``, compared with texts.

The texts lie in ``golden/``: words are compared exactly, numbers to a thousandth, and the last digit may round either way.
After a change that is meant, ``python tests/support/check_texts.py`` writes them anew; look at what differs.
"""

import json
import re

import pytest
from check_texts import GOLDEN, NAMES, ROBOTS, facts, report, robot, same, words_and_numbers

from kinetostatics.checks.chains import joints_of

# ---- the texts ---------------------------------------------------------------------------------------------------------


def test_there_is_a_text_for_each_and_no_other():
    assert sorted(path.stem for path in GOLDEN.glob("*.txt")) == sorted(NAMES)


@pytest.mark.few(5)
@pytest.mark.parametrize("name", NAMES)
def test_check_says_what_it_said(name):
    found, expected = report(name).splitlines(), (GOLDEN / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    for mine, theirs in zip(found, expected, strict=False):
        (words, numbers), (wanted, values) = words_and_numbers(mine), words_and_numbers(theirs)
        assert words == wanted
        assert all(map(same, numbers, values)), (mine, theirs)
    assert len(found) == len(expected)
    assert max(map(len, found)) <= 120
    assert not re.search(r"\bnan\b|\binf\b(?! for rigid)|None|array|np\.|\[\]", "\n".join(found))


# ---- what is warned of -------------------------------------------------------------------------------------------------

#: What is warned of in the robots of the package: meant, and said in the files.
MEANT = {
    "6rus": ["stubby"],  # cranks
    "anymal_standing": ["stubby", "stubby", "the actuation is redundant"],  # thighs, and the housings of the knees
    "tripteron": ["stubby"],
    "ur10": ["stubby"],  # the housing of the elbow
}


@pytest.mark.few(6)
@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_is_warned_of_in_the_packages_robots_but_what_is_meant(name):
    found, meant = facts(name).warnings, MEANT.get(name, [])
    assert len(found) == len(meant), found
    assert ("bearings and actuators count as rigid" in report(name)) == (not facts(name).elastic_joints)
    for warning, words in zip(found, meant, strict=True):
        assert words in warning
    assert not facts(name).problems


#: Of every odd robot, words of the warnings and problems that it is odd for.
ODDITIES = {
    "units_of_sections": ["thicker (100.0 m) than long", "Young's modulus of 200 Pa", "density of 7.82 kg/m³"],
    "units_of_lengths": ["the robot is 640.3 m large"],
    "stubby_and_wiry": [
        "is stubby",
        "times as long as thick (30.00 µm)",
        "shear modulus of 4e+11",
        "thermal expansion of 12 1/K",
    ],
    "masses": [
        "weighs 2.774 kg by its density",
        "weighs nothing, because its density is 0",
        "'bare' has no density and its link no",
    ],
    "rounded_angles": ["angles or lengths are probably rounded"],
    "far_from_closed": ["far from closed: open by 150.0 mm at other_head"],
    "drive_out_of_reach": ["open by 400.0 mm at pivot", "has slide at -374.3 mm"],
    "beyond_limits": ["at the zero pose foot (0°) is beyond its limits"],
    "open_loops": ["cannot be closed", "limb_2 has no elastic parts"],
    "soft_and_hard_joints": ["foot along x is 50 N/m", "the actuator of foot is 20 N·m/rad", "along x is 1e+13 N/m"],
    "no_drives": ["name the driven joints, 1 for a mobility of 1"],
    "two_drives": ["2 actuators for 1 freedom"],
    "rigid_limbs": ["limb_1 and limb_2 have no elastic parts"],
    "followers": ["far from closed", "limb_2 has no elastic parts"],
    "braced_frame": ["limb_1 cannot hold its own weight", "limb_2 has no elastic parts"],
    "seven_axes": [],
    "loose_parts": ["the branch on the platform cannot hold its own weight"],
}


@pytest.mark.few(6)
@pytest.mark.parametrize("name", ODDITIES)
def test_odd_robots_are_warned_of(name):
    found = [*facts(name).problems, *facts(name).warnings]
    for words in ODDITIES[name]:
        assert sum(words in item for item in found) == 1, (words, found)


# ---- numbers for programs ----------------------------------------------------------------------------------------------


@pytest.mark.few(5)
@pytest.mark.parametrize("name", NAMES)
def test_the_same_as_plain_values(name):
    found = json.loads(json.dumps(robot(name).to_dict(), allow_nan=False))
    mobility = found["mobility"]
    if facts(name).zero.closing_error is None:
        assert mobility is None and found["mass"] is None and found["problems"]
        return
    counted = robot(name).mobility
    assert (mobility["platform"], mobility["local"]) == (counted.platform, counted.local)
    assert mobility["redundant_constraints"] == counted.redundant_constraints
    assert sum(item["count"] for item in mobility["local_freedoms"]) == counted.local
    assert sum(item["count"] for item in mobility["redundancies"]) == counted.redundant_constraints
    assert len(mobility["coordinates"]) == counted.platform
    for plain, limb in zip(found["limbs"], robot(name).topology.limbs, strict=True):
        joints = [joint for step in plain["joints"] for joint in step["joints"]]
        assert sorted(joints) == sorted(edge.joint for edge in limb.edges if edge.joint and _moves(name, edge.joint, joints))
    lengths = {beam["name"]: beam["length"] for beam in found["beams"]}
    for beam, model in robot(name).beams.items():
        assert lengths[beam] == pytest.approx(float(model.length(robot(name).zero_frames)[0]), rel=1e-9)


def _moves(name, joint, shown):
    """Whether a joint moves, or is a weld that is shown because it stands at the base or the platform."""
    return robot(name).mechanism.connections[joint].type.name != "fixed" or joint in shown


def test_chains_name_every_joint_once():
    for name in NAMES:
        for limb in facts(name).limbs:
            steps = [*joints_of(limb.graph.chain), *(step for item in limb.graph.hanging for step in joints_of(item.chain))]
            names = [joint for step in steps for joint in step.joints]
            assert len(names) == len(set(names))
