"""Inertias of links, bodies and beams in Pinocchio models."""

import numpy as np
import pinocchio as pin
import pytest
from simple_machines import BEAM, RHO, joint, link, robot

from kinetostatics.elements.weights import link_inertias, weighed


def stick(mass, at=(0.0, 0.0, 0.0)):
    return pin.Inertia(mass, np.array(at), 0.01 * mass * np.eye(3))


def test_every_link_has_its_own_inertia():
    """Two links welded to a third, one of them without mass, on a hinge."""
    machine = robot(
        link("base"), link("arm", 2.0, "0.1 0 0"), link("box", 3.0, "0 0.2 0"), link("platform"), link("tip", 0.5),
        joint("hinge", "continuous", "base", "arm"), joint("weld", "fixed", "arm", "box", "0.5 0 0"),
        joint("seam", "fixed", "box", "tip", "0 0 1"), joint("end", "fixed", "box", "platform", "0 0 0.3"),
    )  # fmt: skip
    found = link_inertias(machine.mechanism.model)
    masses = {"arm": 2.0, "box": 3.0, "platform": 0.0, "tip": 0.5}
    assert {name: found[name].mass for name in masses} == pytest.approx(masses, abs=1e-12)
    np.testing.assert_allclose(found["arm"].lever, [0.1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(found["box"].lever, [0.5, 0.2, 0], atol=1e-12)
    np.testing.assert_allclose(found["tip"].lever, [0.5, 0, 1], atol=1e-12)


@pytest.mark.parametrize(("mass", "weighs"), [(0.0, False), (1e-15, False), (1e-12, True), (1.0, True)])
def test_link_mass_of_rounding_size_counts_as_zero(mass, weighs):
    machine = robot(
        link("base"), link("arm", mass), link("platform", 0.7, "0 0 0.1"), joint("hinge", "continuous", "base", "arm"),
        joint("weld", "fixed", "arm", "platform"),
    )  # fmt: skip
    assert bool(link_inertias(machine.mechanism.model)["arm"].mass) == weighs


def test_weighed_model_has_the_given_inertias():
    model = robot(
        link("base", 9.0), link("arm", 9.0), link("platform", 9.0), joint("hinge", "continuous", "base", "arm"),
        joint("elbow", "continuous", "arm", "platform", "1 0 0"),
    ).mechanism.model  # fmt: skip
    nothing = pin.Inertia.Zero()
    copy = weighed(model, [(1, stick(2.0, (1, 0, 0))), (2, nothing), (1, stick(6.0, (0, 1, 0))), (1, nothing)])
    assert [inertia.mass for inertia in copy.inertias] == [0, 8, 0]
    np.testing.assert_allclose(copy.inertias[1].lever, [0.25, 0.75, 0], atol=1e-15)
    assert model.inertias[2].mass == 9.0 and np.all(np.isfinite(copy.inertias[1].inertia))


def test_beam_has_the_inertia_of_a_prism():
    """Textbook inertia of a 0.02 × 0.06 × 0.5 bar about its middle: m (b² + h²)/12 along it, m (L² + h²)/12 across."""
    machine = robot(
        link("base"), link("bar"), link("platform"), joint("foot", "continuous", "base", "bar", "0.1 0.2 0"),
        joint("head", "fixed", "bar", "platform", "0 0 0.5"),
        f'<beam link="bar" from="foot" to="head" density="{RHO}" y_axis="1 0 0" {BEAM}>'
        '<rectangle width="0.02" height="0.06"/></beam>',
    )  # fmt: skip
    body, found = machine.beams["bar"].inertia_at(machine.zero_frames)
    m = RHO * 0.02 * 0.06 * 0.5
    assert body == machine.mechanism.body_of["bar"][0] and found.mass == pytest.approx(m)
    np.testing.assert_allclose(found.lever, [0, 0, 0.25], atol=1e-12)
    # its width lies along y_axis, x here
    moments = [(0.5**2 + 0.06**2) / 12, (0.5**2 + 0.02**2) / 12, (0.02**2 + 0.06**2) / 12]
    np.testing.assert_allclose(found.inertia, m * np.diag(moments), rtol=1e-9, atol=1e-15)
