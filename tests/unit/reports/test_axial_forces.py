"""Tables of beams tell the axial force at both ends."""

import numpy as np
import pytest
from simple_machines import RHO, bar, joint, link, robot

import kinetostatics as ks

AREA = np.pi * 0.02**2 / 4


def test_the_axial_force_at_both_ends_of_a_hanging_rod():
    """It carries its own weight at the end where it hangs, and the load alone at the other."""
    machine = robot(
        link("base"), link("rod"), link("platform", 1.0), joint("clamp", "fixed", "base", "rod"),
        joint("head", "fixed", "rod", "platform", "0 0 -1"), bar("rod", "clamp", "head", RHO, '<circle diameter="0.02"/>'),
    )  # fmt: skip
    found = ks.analyze(machine.assemble(), gravity=(0, 0, -10))
    np.testing.assert_allclose(found.beams["rod"].points[[0, 10, -1]], [[0, 0, 0], [0, 0, -0.5], [0, 0, -1]], atol=1e-12)
    lines = str(found.report()).splitlines()
    at = next(k for k, line in enumerate(lines) if "N platform end [N]" in line)
    header, row = (
        lines[k].replace(" [", "[").replace("N base end", "N-inner").replace("N platform end", "N-outer").split()
        for k in (at, at + 1)
    )
    cells = dict(zip((name.partition("[")[0] for name in header), row, strict=False))
    assert float(cells["N-inner"]) == pytest.approx(10 + 10 * RHO * AREA, rel=1e-3)
    assert float(cells["N-outer"]) == pytest.approx(10, rel=1e-3)
