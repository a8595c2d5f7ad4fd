"""``kinetostatics check`` of every robot in ``robots/`` and of the odd ones of ``odd_robots.py``, compared with stored texts.

The texts lie in ``golden/``. Words, those of warnings too, are compared exactly, numbers to a thousandth; the last digit may
round either way. After an intended change, ``python tests/support/check_texts.py`` writes them anew; review the differences.
"""

import json
import re

import pytest
from check_texts import GOLDEN, NAMES, ROBOTS, report, robot, same, words_and_numbers

#: Robots of the package that are checked in each run, with all odd ones.
QUICK = ("3rps", "2pru_upr", "delta", "ur10")


def test_golden_texts_and_robots_correspond():
    assert sorted(path.stem for path in GOLDEN.glob("*.txt")) == sorted(NAMES)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in ROBOTS and name not in QUICK)) for name in NAMES]
)
def test_check_report_equals_its_golden_text(name):
    found, expected = report(name).splitlines(), (GOLDEN / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    for mine, theirs in zip(found, expected, strict=False):
        (words, numbers), (wanted, values) = words_and_numbers(mine), words_and_numbers(theirs)
        assert words == wanted
        assert all(map(same, numbers, values)), (mine, theirs)
    assert len(found) == len(expected)
    assert max(map(len, found)) <= 120
    assert not re.search(r"\bnan\b|\binf\b(?! for rigid)|None|array|np\.|\[\]", "\n".join(found))


@pytest.mark.few(5)
@pytest.mark.parametrize("name", NAMES)
def test_plain_values_equal_mobility_and_topology(name):
    found = json.loads(json.dumps(robot(name).to_dict(), allow_nan=False))
    mobility = found["mobility"]
    if name == "open_loops":
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
