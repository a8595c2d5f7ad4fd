"""Code and data with which a page computes: it moves the robot, solves the equilibrium, and draws the result.

The functions of loops, statics and drawing are recorded and written as WebAssembly, see :mod:`kinetostatics.engine.wasm`. Inputs
of the statics are the coordinates x of the solver's tree, load (6) about o and gravity (3), world axes, and the payload: mass
and centre (3) in o-xyz. The outputs contain all numbers of a scene that depend on them.
"""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.buckling.estimate import estimate
from kinetostatics.description.loads import Payload
from kinetostatics.engine.code import code_key, read_stored, store
from kinetostatics.engine.loop_record import Program, newton_record, side_record, start_record
from kinetostatics.engine.pose_record import Pose, PoseModel, example_of
from kinetostatics.engine.recorder import Structure, recorded_input, recording
from kinetostatics.engine.scalars import NotRecordedError, Tape, deciding_by_example
from kinetostatics.engine.wasm import wasm_module
from kinetostatics.kinematics.alternatives import measured_choices, prescribed_platform
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.path_following import longest_strides, turns
from kinetostatics.kinematics.robot_kinematics import JointCoordinates
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING, SolverState
from kinetostatics.layout.report import Json
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import Orientation
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.results.parts import STATIONS
from kinetostatics.results.pose_arrays import Chunk
from kinetostatics.results.result import Result
from kinetostatics.results.warnings import are_regular
from kinetostatics.robot import Robot
from kinetostatics.statics.inertia import INERTIA
from kinetostatics.statics.link_loads import parse_link_loads
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.solution import by_mechanism as split
from kinetostatics.viewer.cards import LARGEST_STRESS
from kinetostatics.viewer.drawn_poses import ShownPoses, labels_of
from kinetostatics.viewer.packing import Packing, packed, packed_code
from kinetostatics.viewer.scene import scene_of
from kinetostatics.viewer.visuals import link_visuals

#: Least measure of well-conditioned coordinates, as a part of the largest one.
WELL = 0.1
#: Payload of the example: mass [kg] and centre [m].
_EXAMPLE_PAYLOAD = (3.0, 0.02, -0.03, 0.05)


class _RecordedPose(ShownPoses):
    """The pose of a result with recorded numbers, at some of the stations of beams.

    Attributes:
        every: every n-th station of a beam is recorded. The page interpolates by polynomials between five stations: uniform beams
            under their weight bend by polynomials of degree four.
    """

    has_texts = False

    def __init__(self, result: Result) -> None:
        self.result, self.robot, self.rigid = result, result.robot, result.link_contributions
        self.indices, self.count, self.step = np.array([0]), 1, 1
        self.contribution_names, self.labels = tuple(result.contributions), labels_of(result)
        self.every = 1 if any(beam.section.places for beam in self.robot.beams.values()) else (STATIONS - 1) // 4

    def beam_line(self, name: str) -> tuple[Array, Array]:
        axes, points = super().beam_line(name)
        return axes, points[:, :: self.every]

    def beam_twists(self, name: str) -> Array:
        return super().beam_twists(name)[:, :, :: self.every]


class _Outputs(Packing):
    """Outputs of a program; as packing of a scene, it adds the scene's numbers and returns their places.

    Attributes:
        rows: indices of the operations that compute the outputs.
    """

    tape: Tape
    rows: list[int]

    def __init__(self, tape: Tape) -> None:
        vars(self).update(bits=None, tape=tape, rows=[])

    def add(self, values: ArrayLike) -> tuple[int, int]:
        """Add outputs; return the number of the first one, and how many there are."""
        added = [self.tape.number_of(value) for value in np.asarray(values, dtype=object).ravel().tolist()]
        self.rows.extend(added)
        return len(self.rows) - len(added), len(added)

    def path(self, values: ArrayLike, width: int = 1) -> dict[str, object]:
        return {"take": self.add(values)}


class _Code:
    """Modules of a page."""

    def __init__(self) -> None:
        self._modules: list[bytes] = []

    def add(self, tape: Tape, rows: Sequence[int], inputs: Sequence[int], parameters: ArrayLike = ()) -> dict[str, Json]:
        """Add a module; return its number, and the numbers of its inputs and outputs."""
        self._modules.append(wasm_module(tape, rows, inputs, np.asarray(parameters, dtype=float)))
        return {"module": len(self._modules) - 1, "inputs": sum(inputs), "outputs": len(rows)}

    def plain(self) -> dict[str, Json]:
        return packed_code(self._modules)


def computing_page(result: Result, by_mechanism: bool = False) -> dict[str, object]:
    """Return code and data with which a page computes results like ``result``, a single pose.

    Args:
        by_mechanism: whether the weight of each limb has two contributions, see :attr:`Result.by_mechanism`.

    Raises:
        NotRecordedError: loops, statics or loads cannot be recorded; the message gives the reason.
    """
    robot, configuration = result.robot, result.configuration
    solution = result.solutions[0]
    if solution.assembly_errors is not None or INERTIA in solution.contributions:
        raise NotRecordedError("the result has assembly errors or a motion")
    carrier, mechanism = None if result.payload is None else result.payload.link, "by mechanism" * by_mechanism
    coordinates = configuration.prescribed or determining_coordinates(configuration)
    digest = hashlib.sha256(pickle.dumps((robot.description, configuration.orientation, result.loads)))
    key = code_key(f"page {digest.hexdigest()} {coordinates} {carrier} {mechanism}")
    stored = read_stored(key)
    if stored is None:
        stored = json.dumps(_recorded(result, coordinates, by_mechanism)).encode()
        store(key, stored)
    return {
        **json.loads(stored),
        "x": configuration.poses.x[:, 0].tolist(),
        "c": configuration.poses.c[:, 0].tolist(),
        "load": result.load.tolist(),
        "gravity": result.gravity.tolist(),
        "payload": _payload_of(result),
        "carrier": carrier,
        "warnings": [*robot.warnings],
        "efforts": [
            [name, limit, robot.mechanism.connections[name].type.force_unit]
            for name, limit in robot.description.actuator_limits("effort").items()
        ],
        "mass": float(robot.weights.masses(configuration.frames).sum()),
    }


def _recorded(result: Result, coordinates: Sequence[str], by_mechanism: bool) -> dict[str, object]:
    """Return the code, and the data that depend neither on pose nor on loads."""
    robot, convention, code = result.robot, result.configuration.orientation, _Code()
    kinds = {"actuators": robot.actuator_coordinates}
    if coordinates:
        kinds["platform"] = prescribed_platform(tuple(coordinates), convention)
    return {
        "lines": {kind: _line(robot, given, code) for kind, given in kinds.items() if given.size},
        "closed": _closed(robot, convention, code),
        "statics": _statics(result, by_mechanism, code),
        "zero": {"x": robot.zero_poses.x[:, 0].tolist(), "c": robot.zero_poses.c[:, 0].tolist()},
        "length": robot.length,
        "size": robot.size,
        "rough": robot.rough_residual,
        "shrinking": SHRINKING,
        "most_corrections": MOST_CORRECTIONS,
        "code": code.plain(),
    }


def determining_coordinates(pose: Configuration) -> tuple[str, ...]:
    """Of the well-conditioned sets of platform coordinates that determine a pose, return the one with the most angles."""
    convention = pose.orientation
    measures = measured_choices(pose.robot, convention, pose.poses)
    least = WELL * max(measures.values(), default=0.0)
    good = [coordinates for coordinates, measure in measures.items() if measure >= least]
    coordinates = min(good, key=lambda coordinates: sum(name in "xyz" for name in coordinates), default=())
    return tuple(sorted(coordinates, key=convention.pose_names.index))


# ---- loops ---------------------------------------------------------------------------------------------------------------


def _line(robot: Robot, given: PrescribedCoordinates, code: _Code) -> dict[str, object]:
    """Return the programs that follow straight lines of prescribed coordinates, and their data."""
    prescribed = robot.mobility_analysis.with_dofs(given)
    generic = robot.generic_poses.take(np.array([0]))
    example = SolverState(generic.x, robot.solver.origin(prescribed, generic)[1])
    numbers, (nq, n) = Structure((robot.solver, prescribed)).values, (len(example.x), prescribed.size)

    def added(record: Callable[..., Program], *inputs: int) -> dict[str, Json]:
        program = record(robot.solver, prescribed, example)
        return code.add(program.tape, (*program.numbers, *program.truths), inputs, numbers)

    return {
        "names": robot.actuator_names if not given.positions and not given.angles else _names(given),
        "idle": robot.actuators_outside_limbs,
        "turns": turns(robot.solver, prescribed).tolist(),
        "newton": added(newton_record, nq + 8, n + 1),
        "side": None if prescribed.local_dofs else added(side_record, nq, 3, nq, 3),
        "start": added(start_record, nq, 3, n, 1),
        "longest": longest_strides(robot.solver, prescribed).tolist(),
        "impose": [*_imposed(robot, prescribed)],
        "angles": [[k, prescribed.first_angle + row] for row, k in enumerate(prescribed.angles)],
    }


def _names(given: PrescribedCoordinates) -> list[str]:
    assert given.orientation is not None
    return [*("xyz"[k] for k in given.positions), *(given.orientation.names[k] for k in given.angles)]


def _imposed(robot: Robot, prescribed: PrescribedCoordinates) -> Iterator[dict[str, Json]]:
    """Yield what :meth:`Solver.impose` writes into x: multiples of coordinates plus offsets, or cosine and sine of these."""
    given = [(robot.solver.joint_of_column[column], row, 1.0, 0.0) for row, column in enumerate(prescribed.columns)]
    for coupling in robot.equations.couplings.items:
        if coupling.leader.first_v in prescribed.columns:
            row = prescribed.columns.index(coupling.leader.first_v)
            given.append((coupling.follower, row, coupling.multiplier, coupling.offset))
    for joint, row, multiplier, offset in given:
        yield {"at": joint.first_q, "of": row, "times": multiplier, "plus": offset, "turns": joint.type.endless}


def _closed(robot: Robot, convention: Orientation, code: _Code) -> dict[str, object]:
    """Return the program of a closed pose: errors of the loops, coordinates, and which joints are within their limits."""
    tape, example = Tape(), robot.generic_poses.x[:, :1]
    outputs, zero = _Outputs(tape), np.zeros((6, 1))
    model = PoseModel(JointCoordinates(robot.solver), robot.statics)
    limits = []
    with recording():
        pose = Pose(model, recorded_input(tape, 0, example), zero, zero[:3])
        R, o = robot.mechanism.platform_pose(pose.frames)
        places: dict[str, object] = {
            "rough": outputs.add(np.max(np.abs(pose.closures), axis=0, initial=0.0)),
            "opening": outputs.add(pose.opening()),
            "actuators": outputs.add(pose.actuators()),
            "platform": outputs.add(np.concatenate([o, convention.coordinates(R)])),
        }
        for name, value, (lower, upper), within in model.joints.limited(pose.placed.q, pose.frames):
            slides = robot.mechanism.connections[name].type.is_slide
            ends = {key: end if np.isfinite(end) else None for key, end in (("lower", lower), ("upper", upper))}
            joint = {"name": name, **ends, "slides": slides, "value": outputs.add(value)}
            if np.isfinite([lower, upper]).any():
                limits.append({**joint, "within": outputs.add(within)})
        places["holds"] = outputs.add(tape.holds())
    names = {"actuators": list(robot.description.actuated), "platform": convention.pose_names}
    return {**code.add(tape, outputs.rows, [len(example)]), "places": places, "limits": limits, "names": names}


# ---- statics and drawing -------------------------------------------------------------------------------------------------


def _statics(result: Result, by_mechanism: bool, code: _Code) -> dict[str, object]:
    """Return the program of the equilibrium and of its drawing."""
    robot, payload = result.robot, result.payload
    tape, (x, load, gravity) = Tape(), (robot.generic_poses.x[:, :1], *example_of(robot.statics)[1:])
    examples = x, load, gravity, np.array([_EXAMPLE_PAYLOAD]).T
    outputs = _Outputs(tape)
    with recording():
        x, load, gravity, mass = (recorded_input(tape, number, array) for number, array in enumerate(examples))
        pose = Pose(PoseModel(JointCoordinates(robot.solver), robot.statics), x, load, gravity)
        given = parse_link_loads(robot.statics, result.loads, Payload(1.0, link=None if payload is None else payload.link))
        assert given is not None
        *others, last = given.map(lambda array: array[..., None]).loads
        applied = replace(given, loads=(*others, replace(last, point=mass[1:], mass=mass[:1]))).at(pose.frames, gravity)
        solution = pose.under(applied)
        shown = _recorded_result(result, pose, split(robot.statics, solution) if by_mechanism else solution)
        values = {name: outputs.add(OF_EQUILIBRIUM[name](robot.statics, solution)) for name in _VALUES}
        # what is drawn: computed here, where conditions become guards
        for name in ("beam_contributions", "link_contributions", "actuator_contributions", "base_wrench", "joint_wrenches"):
            getattr(shown, name)
        values["holds"] = outputs.add(tape.holds())
        values["regular"] = outputs.add(are_regular(robot, solution))
        if not robot.description.springs:
            values["bound"] = outputs.add(estimate(robot.members.structure, solution))
        with deciding_by_example():
            for results in shown.beams.values():  # eigenvalues are not recorded
                vars(results._euler_ratio)["of_beams"] = dict.fromkeys(robot.beams, np.full((), np.nan))
            drawn = _RecordedPose(shown)
            scene = scene_of(drawn, link_visuals(robot.description))
            template: dict[str, Json] = {**scene.moving(outputs), **scene.details(outputs)}
    sections: dict[str, Json] = {}
    firsts = [card["first"] for path, card in template["cards"].items() if path.startswith("beams/")]
    for name, beam in robot.description.beams.items():
        if (found := robot.beams[name].section.forms(beam.poisson_ratio)) is not None:
            (forms, rings), card = found, template["cards"][f"beams/{name}"]
            key = next((key for key, known in sections.items() if known["forms"] == packed(forms, "<f8")), str(len(sections)))
            sections[key] = {"forms": packed(forms, "<f8"), "rings": rings}
            card |= {"section": key, "stress_row": [row["words"] for row in card["rows"]].index(LARGEST_STRESS)}
    program = code.add(tape, outputs.rows, [len(example) for example in examples])
    return {**program, "places": values, "template": template, "sections": sections, "beams": firsts if drawn.every > 1 else []}


#: Outputs of the equilibrium by which the page judges a pose, and which it returns to scripts.
_VALUES = ("twist", "actuator_forces", "stiffness", "singular", "indeterminate", "basis_degenerate", "doubtful")


def _recorded_result(result: Result, pose: Pose, solution: Solution) -> Result:
    one = np.ones(1, dtype=bool)
    configuration = replace(
        result.configuration, poses=SolverState(pose.x, np.zeros((3, 1))), model_q=pose.placed.q, frames=pose.frames,
        loop_residual=pose.placed.residual, reached=one,
    )  # fmt: skip
    recorded = Result(configuration, (), slice(None), (Chunk(result.robot, [solution]),), one)
    vars(recorded)["_valid"] = one
    return recorded


def _payload_of(result: Result) -> list[float]:
    if result.payload is None:
        return [0.0] * 4
    return [float(np.asarray(result.payload.mass)), *np.asarray(result.payload.center, dtype=float).tolist()]
