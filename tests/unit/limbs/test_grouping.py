"""Limbs are stacked in one group only if they have the same rigid directions."""

import numpy as np
import pytest
from mechanisms import Beam, Edge, Joint, Link, Mechanism, Stiffness, circle, write_mechanism

import kinetostatics as ks
from kinetostatics.limbs.compliance import split_rigid


@pytest.mark.parametrize(("group", "first", "second"), [("linear", 0, 1), ("linear", 2, 1), ("angular", 1, 2)])
def test_limbs_compliant_along_different_wrenches_are_not_stacked(group, first, second):
    """Bolts between base and platform, each elastic in one direction, but not along the same canonical wrench."""

    def bolt(name, direction, height):
        values = [np.inf] * 3
        values[direction] = 3e5
        joint = Joint(name, "F", (0.3, 0.2, height), stiffness=Stiffness(**{group: tuple(values)}))
        return Edge(joint, "base", "platform")

    rod = [Edge(Joint("foot", "F", (0, 0, 0)), "base", "rod"), Edge(Joint("head", "F", (0.1, 0, 0.8)), "rod", "platform")]
    machine = Mechanism(
        (*rod, bolt("one", first, 0.1), bolt("two", second, 0.3)),
        (Link("rod"),),
        (Beam("rod", "rod", "foot", "head", circle(0.03)),),
    )
    robot = write_mechanism(machine, cuts={"one", "two"}).robot()
    for statics in ks.analyze(robot.assemble()).solutions[0].statics:
        if statics.group.rigid_directions:
            assert split_rigid(statics.C, statics.group.soft)[2].all()


def test_fast_split_is_sure_only_where_soft_wrenches_are_independent():
    """Two wrenches along which a limb gives way, more and more alike, and one along which it is rigid."""
    alike = 1 - np.array([1e-4, 1e-5, 1e-7, 1e-8])
    C = np.zeros((3, 3, 1, 4))
    C[0, 0], C[1, 1], C[0, 1], C[1, 0] = 1.0, 1.0, alike, alike
    assert split_rigid(C, (0, 1))[2].tolist() == [[True, True, False, False]]
