"""Reports of modes, frequency responses and buckling, of one pose and of a batch: numbers equal the arrays."""

import json
import re

import numpy as np
import pytest
from package_robots import robot

import kinetostatics as ks


@pytest.fixture(scope="module")
def poses():
    """One pose of the five-bar, and a batch of two."""
    machine = robot("five_bar")
    return machine.assemble(), machine.assemble(actuators={"shoulder_1": np.array([0.0, 0.1]), "shoulder_2": 0.0})


def cells(report, title):
    """Return the rows of a part of a report, split at two spaces and more."""
    lines = str(report).partition(f"\n{title}")[2].partition("\n\n")[0].splitlines()
    return [re.split(r" {2,}", line.strip()) for line in lines[1:]]


def test_modes_report_equals_the_arrays(poses):
    found = ks.modes(poses[0], 3)
    rows = cells(found.report(), "Modes, and their effective masses")[1:]
    assert [float(row[1]) for row in rows] == pytest.approx(found.frequencies, rel=1e-3)
    masses = [[float(cell) for cell in row[2:]] for row in rows]
    np.testing.assert_allclose(masses, 100 * found.effective_masses, atol=0.051)
    for title, shares in (("Strain", found.strain_energy_shares), ("Kinetic", found.kinetic_energy_shares)):
        table = {name: [float(cell) for cell in row] for name, *row in cells(found.report(), f"{title} energy by part")[1:]}
        assert np.sum(list(table.values()), axis=0) == pytest.approx([100] * 3, abs=0.3)
        for name, row in table.items():
            assert row == pytest.approx(100 * shares[name], abs=0.051)
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["frequencies"] == found.frequencies.tolist()
    batch = ks.modes(poses[1], 2)
    low, _, high, unit = cells(batch.report(), "Ranges")[1][1].split()
    assert unit == "Hz" and [float(low), float(high)] == pytest.approx(np.sort(batch.frequencies[:, 0]), rel=1e-3)


def test_frequency_response_report_equals_the_arrays(poses):
    found = ks.frequency_response(poses[1], [1.0, 20.0, 5.0], damping=0.03)
    for title, array in (("Compliance", found.compliance), ("Transmissibility", found.transmissibility)):
        for k, row in enumerate(cells(found.report(), title)[1:]):
            peaks = np.abs(array[..., k, k]).max(axis=0)
            assert float(row[1].split()[0]) == pytest.approx(peaks.max(), rel=2e-3)
            assert float(row[2]) == found.frequencies[np.argmax(peaks)]
    assert "Damping: ratio 0.03." in str(found) and repr(found).endswith("; 1 to 20 Hz, 3 frequencies>")
    assert np.shape(found.to_dict()["compliance_phase"]) == (2, 3, 6, 6)


def test_buckling_report_equals_the_load_factors():
    """The first factors of the upright tripod are equal and share a row."""
    machine = robot("3rps")
    poses = machine.assemble(platform={"z": np.array([0.5, 0.55]), "rx": 0.0, "ry": 0.0})
    found = [ks.analyze(pose, [0, 0, -5e4, 0, 0, 0]).buckling(3) for pose in (machine.assemble(), poses)]
    rows = cells(found[0].report(), "Load factors")[1:]
    assert [float(row[1]) for row in rows] == pytest.approx(np.unique(found[0].load_factors.round(3)), rel=1e-3)
    assert rows[0][2].startswith("rod_") and len(", ".join(row[0] for row in rows).split(", ")) == 3
    assert cells(found[1].report(), "Least over")[0][1] == f"{found[1].load_factors.min():.4g}"


def test_a_rigid_robot_has_no_frequency():
    machine = robot("five_bar")
    for name in machine.description.beams:
        machine = ks.Robot(machine.description.without_beam(name))
    assert repr(ks.modes(machine.assemble())).endswith("no natural frequency: no elastic part carries a mass>")
