"""Every quantity that may be minimized or required, against closed forms."""

import textwrap

import numpy as np
import pytest
from parametric_machines import BEAM, HEAD, INERTIA, RHO, E, moving

import kinetostatics as ks
from kinetostatics.design.problem import REQUIRABLE, Requirable, parse_requirement

D, L, BEYOND, MASS, FX, FZ = 0.04, 0.8, 0.2, 5.0, 20e3, 500.0
#: Angles of the motor: the rod is pressed, bent and turned differently at each.
ANGLES = np.array([-0.2, 0.0, 0.3])
#: Force and moment from any direction.
FORCE, MOMENT = 500.0, 20.0


def satisfied(name):
    """Return a requirement that holds."""
    sizes = {"force": f"({FORCE:g} N)", "moment": f"({MOMENT:g} N·m)", None: ""}
    return f"{name}{sizes[REQUIRABLE[name].argument]} {'> 1e-9' if REQUIRABLE[name].better == 'large' else '< 1e12'}"


def worst(name, values):
    """Return the worst of all poses."""
    return np.min(values) if REQUIRABLE[name].better == "large" else np.max(values)


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    """All quantities of a lift on which a motor turns a round rod: at the rod's end, and at a tool's tip beyond."""
    text = f"""\
        {HEAD.format("crane")}
          <xacro:arg name="diameter" default="0.05"/>
          <link name="base"/>
          {moving("lift", "prismatic", "base", "carriage", "0 0 1")}{moving("motor", "revolute", "carriage", "rod", "0 -1 0")}
          <link name="end"><inertial><mass value="{MASS}"/>{INERTIA}</inertial></link>
          <joint name="weld" type="fixed"><parent link="rod"/><child link="end"/><origin xyz="{L} 0 0"/></joint>
          <beam link="rod" from="motor" to="weld" density="{RHO}" {BEAM.replace("$(arg E)", str(E))}>
            <circle diameter="$(arg diameter)"/>
          </beam>
          <platform link="end"/>
          <transmission name="lifting"><joint name="lift"/></transmission>
          <transmission name="turning"><joint name="motor"/></transmission>
        </robot>"""
    path = tmp_path_factory.mktemp("files") / "crane.urdf.xacro"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    over = {"lift": 0.1, "motor": ANGLES}
    given = {"load": [-FX, 0, -FZ, 0, 0, 0], "gravity": (0, 0, 0)}
    found = {}
    for where, tool in (("end", None), ("tip", (BEYOND, 0, 0))):
        best = ks.optimize(
            path, {"diameter": [D, 2 * D]}, "mass", [satisfied(name) for name in REQUIRABLE], actuators=over, tool=tool, **given
        )
        assert best.feasible and best.parameters["diameter"] == D
        found[where] = {item.name: item.worst for item in best.requirements}
    return found


def closed_forms(beyond):
    """Return all quantities of a cantilever (Timoshenko's Strength of Materials, I), the tip's ``beyond`` its end."""
    area, EI, GJ = np.pi * D**2 / 4, E * np.pi * D**4 / 64, E / 2.6 * np.pi * D**4 / 32
    pressing = FX * np.cos(ANGLES) + FZ * np.sin(ANGLES)
    bending = np.abs(FX * np.sin(ANGLES) - FZ * np.cos(ANGLES))
    own = (L**3 / 3 + beyond * L**2 + beyond**2 * L) / EI  # of a force where it acts
    return {
        "mass": RHO * area * L + MASS,
        "sag": np.hypot(pressing * L / (E * area), bending * (L**3 / 3 + beyond * L**2 / 2) / EI),
        "rotation": bending * L**2 / (2 * EI),
        "deflection_any_direction": FORCE * own,
        "rotation_any_direction": MOMENT * L / GJ,
        "least_translational_stiffness": 1 / own,
        "least_rotational_stiffness": GJ / L,
        "actuator_force": FZ,
        "actuator_torque": bending * L,
        "utilization": np.maximum(FZ, bending * L) / 1.0,  # the efforts of the file are 1
        "safety_factor": 1.0 / np.maximum(FZ, bending * L),  # buckling is farther away
        "stress": pressing / area + bending * L * D / 2 / (np.pi * D**4 / 64),
        "buckling": pressing / (np.pi**2 * EI / (2 * L) ** 2),  # clamped and free
    }


@pytest.mark.parametrize("name", REQUIRABLE)
def test_every_quantity_has_its_closed_form(name, crane):
    """A new quantity needs its row in ``closed_forms``."""
    for where, beyond in (("end", 0.0), ("tip", BEYOND)):
        expected = worst(name, closed_forms(beyond)[name])
        if name == "buckling":  # the moments of the transverse force, too, make the rod turn and twist
            assert 1 < crane[where][name] / expected < 1.0005
        else:
            assert crane[where][name] == pytest.approx(expected, rel=1e-9), where


@pytest.mark.parametrize(("text", "values", "margins"), [
    ("stress < 200MPa", [100e6, 200e6, 300e6, np.nan], [0.5, 0, -0.5, -1]),
    ("least_translational_stiffness > 2N/um", [1e6, 2e6, 3e6, np.inf, np.nan], [-0.5, 0, 0.5, 1e3, -1]),
])  # fmt: skip
def test_missing_values_violate_requirements(text, values, margins):
    np.testing.assert_allclose(parse_requirement(text).margins(np.array(values)), margins, atol=1e-15)


@pytest.mark.few(1)
@pytest.mark.parametrize("minimize, subject_to", [("mass", ["sag < 1mm", "stress < 1e12Pa"]), ("stress", ["sag < 1mm"])])
def test_designs_with_missing_values_are_infeasible(monkeypatch, minimize, subject_to):
    """Forces may be indeterminate at a pose whose displacement is known, whether they are limited or minimized."""
    own = REQUIRABLE["stress"].function

    def lost(result, tip, argument):
        found = np.array(own(result, tip, argument))
        found[1] = np.nan
        return found

    given = "3rps", {"rod_diameter": "48mm,52mm"}, minimize, subject_to, {"z": [0.5, 0.55], "rx": 0.0, "ry": 0.0}
    assert ks.optimize(*given).feasible
    monkeypatch.setitem(REQUIRABLE, "stress", Requirable("stress", lost, None, "stress, but for one pose"))
    best = ks.optimize(*given)
    assert not best.feasible and (
        minimize == "stress" or (np.isnan(best.requirements[1].worst) and best.requirements[1].margin == -1)
    )
