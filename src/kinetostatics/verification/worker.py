"""Program that solves frames in OpenSeesPy: it reads a frame as JSON from standard input and writes the solution as JSON.

It runs in a separate process: OpenSees has a single model per process, and the caller may be using it. OpenSees also
prints messages even when Python exits, and ends the process on some errors. The program imports nothing of the package, since
that would take longer than the solution.

The frame's numbers are dimensionless: :mod:`kinetostatics.verification.opensees` divides stiffnesses by the largest one, so that
the penalties of joints are in the range of double precision.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import sys
from operator import neg
from pathlib import Path
from types import ModuleType
from typing import TypeAlias, TypedDict


class SpringInput(TypedDict):
    """A spring between two nodes; where its stiffness is None, the direction is constrained."""

    tag: int
    nodes: list[int]
    stiffness: list[float | None]
    axes: list[float]
    assembly_error: list[float]


class BeamInput(TypedDict):
    """An element of a beam: ``load`` and ``mass`` are per length; ``at_ends`` (12,) are further wrenches on its two ends."""

    tag: int
    nodes: list[int]
    stiffness: list[float]
    z: list[float]
    load: list[float]
    at_ends: list[float]
    mass: float


class Frame(TypedDict):
    """A frame, dimensionless.

    Attributes:
        ties: for each rigid arm, the reference node and the node tied to it.
        loads: nodes with forces and moments.
        probes: nodes whose displacements are computed.
        masses: nodes with masses.
        modes: number of the lowest eigenvalues to compute in place of displacements; 0 for displacements.
        springs_at_level: stiffness of constrained and of free directions, for each solution.
    """

    nodes: list[list[float]]
    fixed: list[int]
    ties: list[list[int]]
    springs: list[SpringInput]
    beams: list[BeamInput]
    loads: list[tuple[int, list[float]]]
    probes: list[int]
    masses: list[tuple[int, float]]
    modes: int
    springs_at_level: list[tuple[float, float]]


#: Largest number of equations for which eigenvalues of dense matrices are computed.
FEW = 100

#: Displacements of the probes ("moved", a row for each load) and forces ("springs", "beams", a row for each); or
#: eigenvalues ("squares", a single row).
Answer: TypeAlias = dict[str, list[list[float]]]


def load_opensees() -> ModuleType:
    """Import OpenSees.

    The wheel for Linux contains BLAS, LAPACK and their dependencies. On a system that lacks these libraries, the loader does not
    find them in the wheel; therefore they are loaded first.
    """
    try:
        import openseespy.opensees as ops
    except (ImportError, RuntimeError):
        specification = importlib.util.find_spec("openseespylinux")
        if specification is None or specification.origin is None:
            raise
        for name in ("libquadmath.so.0", "libgfortran.so.4", "libblas.so.3"):
            path = Path(specification.origin).parent / "lib" / name
            if path.exists():
                ctypes.CDLL(str(path))
        import openseespy.opensees as ops
    return ops


def build(ops: ModuleType, frame: Frame, penalty: float, regularization: float) -> None:
    """Build the frame with stiffness ``penalty`` in constrained directions and ``regularization`` in free directions."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for tag, point in enumerate(frame["nodes"]):
        ops.node(tag, *point)
    for tag in frame["fixed"]:
        ops.fix(tag, 1, 1, 1, 1, 1, 1)
    for reference, tied in frame["ties"]:
        ops.rigidLink("beam", reference, tied)
    ops.uniaxialMaterial("Elastic", 1, penalty)
    ops.uniaxialMaterial("Elastic", 2, regularization)
    for spring in frame["springs"]:
        # materials 1 and 2 are common to all springs; a spring's own materials have tags from 10 on
        materials = []
        for direction, stiffness in enumerate(spring["stiffness"], 1):
            materials.append({None: 1, 0.0: 2}.get(stiffness, 10 * spring["tag"] + direction))
            if materials[-1] > 2:
                ops.uniaxialMaterial("Elastic", materials[-1], stiffness)
        springs = ("-mat", *materials, "-dir", *range(1, 7))
        ops.element("zeroLength", spring["tag"], *spring["nodes"], *springs, "-orient", *spring["axes"])
    for beam in frame["beams"]:
        EA, GAy, GAz, GJ, EIy, EIz = beam["stiffness"]
        ops.geomTransf("Linear", beam["tag"], *beam["z"])
        # E = 1; OpenSees uses J as the polar moment of area in the rotary inertia: J is set to it, and G so that G J is right
        E, J = 1.0, EIy + EIz
        G = GJ / J
        section = (E, G, EA, J, EIy, EIz, GAy / G, GAz / G)
        mass = ("-mass", beam["mass"], "-cMass") if beam["mass"] else ()
        ops.element("ElasticTimoshenkoBeam", beam["tag"], *beam["nodes"], *section, beam["tag"], *mass)
    for tag, mass_there in frame["masses"]:
        ops.mass(tag, *[mass_there] * 3, 0.0, 0.0, 0.0)
    ops.timeSeries("Constant", 1)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("FullGeneral")
    ops.integrator("LoadControl", 1.0)
    ops.algorithm("Linear", "-factorOnce")
    ops.analysis("Static", "-noWarnings")


def solve(ops: ModuleType, frame: Frame, penalty: float, regularization: float) -> Answer:
    """Return displacements of the probes under the loads, then under unit loads; forces of springs and beams under the loads."""
    build(ops, frame, penalty, regularization)
    answer = under_loads(ops, frame, penalty)
    for probe in frame["probes"]:
        for k in range(6):
            start(ops, [(probe, [float(k == direction) for direction in range(6)])])
            # the second step removes the residual forces of the first, which are rounding errors
            analyze(ops, 2)
            answer["moved"].append(displacements(ops, frame))
    return answer


def eigenvalues(ops: ModuleType, frame: Frame, penalty: float, regularization: float) -> Answer:
    """Return the lowest eigenvalues.

    Arnoldi's method needs more equations than eigenvalues, and enough masses; a frame with few equations is solved by LAPACK.
    """
    build(ops, frame, penalty, regularization)
    equations = 6 * (len(frame["nodes"]) - len(frame["fixed"]) - len(frame["ties"]))
    try:
        return {"squares": [ops.eigen("-genBandArpack" if equations > FEW else "-fullGenLapack", min(frame["modes"], equations))]}
    except Exception:
        raise SingularFrameError("the frame has no eigenvalues") from None


def displacements(ops: ModuleType, frame: Frame) -> list[float]:
    return [float(value) for probe in frame["probes"] for value in ops.nodeDisp(probe)]


def assembly_error_forces(spring: SpringInput, penalty: float) -> list[float]:
    """Return force and moment (6,), world axes, on a spring's second node that are equivalent to its assembly error."""
    x, y = spring["axes"][:3], spring["axes"][3:]
    z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
    along_axes = [
        (penalty if stiffness is None else stiffness) * assembly_error
        for stiffness, assembly_error in zip(spring["stiffness"], spring["assembly_error"], strict=True)
    ]
    return [x[k] * part[0] + y[k] * part[1] + z[k] * part[2] for part in (along_axes[:3], along_axes[3:]) for k in range(3)]


def under_loads(ops: ModuleType, frame: Frame, penalty: float) -> Answer:
    """Return displacements and forces under loads and assembly errors.

    An assembly error is replaced by equivalent forces on both nodes of a spring or beam; these are not part of its internal
    force. A uniform moment along a beam, which OpenSees does not support, is replaced in the same way.

    The force of a stiff spring follows from a small difference of displacements and loses digits. The unbalanced forces of all
    nodes are therefore applied to the unloaded frame, twice, and the results are added.
    """
    answer: Answer = {"moved": [], "springs": [], "beams": []}
    assembly_errors = [assembly_error_forces(spring, penalty) for spring in frame["springs"]]
    loads = list(frame["loads"])
    pairs = [
        (spring["nodes"], [*map(neg, forces), *forces]) for spring, forces in zip(frame["springs"], assembly_errors, strict=True)
    ]
    for nodes, forces in [*pairs, *((beam["nodes"], beam["at_ends"]) for beam in frame["beams"])]:
        if any(forces):
            loads += [(nodes[0], forces[:6]), (nodes[1], forces[6:])]
    free = sorted(set(range(len(frame["nodes"]))) - set(frame["fixed"]))
    for step in range(3):
        start(ops, loads)
        if step == 0:
            for beam in frame["beams"]:
                x, y, z = beam["load"]
                ops.eleLoad("-ele", beam["tag"], "-type", "-beamUniform", y, z, x)
        analyze(ops, 1)
        responses = {
            "moved": [displacements(ops, frame)],
            "springs": [ops.eleResponse(spring["tag"], "force")[:6] for spring in frame["springs"]],
            "beams": [ops.eleResponse(beam["tag"], "force") for beam in frame["beams"]],
        }
        if step == 0:
            responses["springs"] = added(responses["springs"], assembly_errors)
            responses["beams"] = added(responses["beams"], [[*map(neg, beam["at_ends"])] for beam in frame["beams"]])
        for key, rows in responses.items():
            answer[key] = added(answer[key], rows) if answer[key] else rows
        ops.reactions()
        loads = [(tag, [-value for value in ops.nodeReaction(tag)]) for tag in free]
    return answer


def added(some: list[list[float]], more: list[list[float]]) -> list[list[float]]:
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(some, more, strict=True)]


def start(ops: ModuleType, loads: list[tuple[int, list[float]]]) -> None:
    """Reset the frame to its unloaded state and apply loads."""
    ops.remove("loadPattern", 1)
    ops.reset()
    ops.pattern("Plain", 1, 1)
    for tag, load in loads:
        ops.load(tag, *load)


class SingularFrameError(Exception):
    """The frame's equations have no solution."""


def analyze(ops: ModuleType, steps: int) -> None:
    if ops.analyze(steps) != 0:
        raise SingularFrameError("the frame has no solution")


def main() -> None:
    """Read a frame, solve it for every entry of ``springs_at_level``, write the answers."""
    output = os.dup(1)
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)
    answer: dict[str, object]
    try:
        frame = json.load(sys.stdin)
        ops = load_opensees()
    except Exception as error:
        cause = error.__context__ or error
        answer = {"missing": f"{type(cause).__name__}: {cause}"}
    else:
        try:
            ask = eigenvalues if frame["modes"] else solve
            answer = {"levels": [ask(ops, frame, *level) for level in frame["springs_at_level"]]}
        except SingularFrameError as error:
            answer = {"singular": str(error)}
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
    with os.fdopen(output, "w") as stream:
        json.dump(answer, stream)


if __name__ == "__main__":
    main()
