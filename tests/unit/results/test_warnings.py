"""When a result warns of members that buckle: once for those of one mode, from a twentieth of its Euler load on."""

from types import SimpleNamespace

import numpy as np
import pytest

from kinetostatics.results.warnings import _buckling, _near, undetermined_parts


def result(**ratios):
    """Beams, with the ratio of each to its Euler load."""
    beams = {name: SimpleNamespace(name=name, euler_ratio=np.array(ratio)) for name, ratio in ratios.items()}
    return SimpleNamespace(beams=beams)


def test_what_buckles_together_is_warned_of_once():
    found = result(a=[0.2, 1.5], b=[0.2, 1.5], c=0.3, d=[np.nan, 0.0])
    assert _buckling(found) == ["beams a, b buckle: the forces are 150 % of those at which this begins"]
    assert _near(found) == ["the forces are 30 % of those at which beam c buckles"]


def test_from_which_part_of_the_euler_load_on():
    assert [len(_near(result(c=part))) for part in (0.049, 0.051, 0.999, 1.0)] == [0, 1, 1, 0]
    assert [len(_buckling(result(c=part))) for part in (0.049, 0.999, 1.0, 1.001)] == [0, 0, 1, 1]


@pytest.mark.parametrize(("part", "joints"), [(0.9e-9, "a, c"), (1.1e-9, "a, b, c"), (-1.1e-9, "a, b, c")])
def test_joints_that_rounding_alone_loads_have_no_part_in_a_self_stress(part, joints):
    """Two cut joints that carry opposite forces of 2 N but for ``part`` of them: b carries their sum, a and c one each."""
    loose = np.zeros((2, 6, 1, 1, 1))
    loose[0, 0], loose[1, 0] = 2.0, -2.0 * (1 + part)
    edges = [
        SimpleNamespace(joint=name, cut_joints=signs)
        for name, signs in (("a", ((0, 1),)), ("b", ((0, 1), (1, 1))), (None, ((0, 1),)), ("c", ((1, -1),)), ("d", ((0, 0),)))
    ]
    item = SimpleNamespace(group=SimpleNamespace(limbs=[SimpleNamespace(name="limb_1", edges=edges)]), loose=loose)
    undetermined = np.zeros((2, 1, 1), dtype=bool)
    found = SimpleNamespace(solutions=[SimpleNamespace(statics=[item], undetermined=[undetermined])])
    rest = "their forces are statically indeterminate; undetermined forces are NaN"
    assert undetermined_parts(found) == f"the rigid rings in limb_1 ({joints}) are overconstrained in themselves: {rest}"
    undetermined[1] = True
    assert undetermined_parts(found).startswith("the rigid limbs limb_1 overconstrain one another and the rigid rings in limb_1")
    loose[:] = 0
    undetermined[:] = False
    assert undetermined_parts(found) == f"rigid parts are overconstrained: {rest}"
