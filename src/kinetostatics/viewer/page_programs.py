"""Programs of a page that computes: loops, statics and drawing, recorded and written as WebAssembly.

See :mod:`kinetostatics.engine.wasm`. Inputs of the statics are the coordinates x of the solver's tree, load (6) about o and
gravity (3), world axes, and the payload: mass and centre (3) in o-xyz. The outputs contain all numbers of a scene that depend on
them. The last inputs of each program are the numbers in which the robots of the page differ.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.buckling.estimate import estimate
from kinetostatics.description.loads import Payload
from kinetostatics.engine.loop_record import Program, newton_record, side_record, start_record
from kinetostatics.engine.pose_record import Pose, PoseModel, example_of
from kinetostatics.engine.recorder import Structure, recorded_input, recording
from kinetostatics.engine.scalars import Tape, deciding_by_example
from kinetostatics.engine.wasm import wasm_module
from kinetostatics.kinematics.alternatives import prescribed_platform
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.path_following import longest_strides, turns
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.layout.report import Json
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.results.parts import STATIONS
from kinetostatics.results.pose_arrays import Chunk
from kinetostatics.results.result import Result
from kinetostatics.results.warnings import are_regular, generic_forces
from kinetostatics.robot import Robot
from kinetostatics.statics.link_loads import parse_link_loads
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.solution import by_mechanism as split
from kinetostatics.viewer.cards import LARGEST_STRESS, Card, wrenches_on_links
from kinetostatics.viewer.description import Mesh
from kinetostatics.viewer.drawn_poses import ShownPoses, labels_of
from kinetostatics.viewer.packing import Packing, packed
from kinetostatics.viewer.scene import meshes_of, scene_of
from kinetostatics.viewer.visuals import link_visuals

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
    """Modules of a page.

    Attributes:
        counts: numbers of parameters by the kind of data from which programs are recorded.
    """

    def __init__(self, counts: Mapping[str, int]) -> None:
        self.counts, self.modules = counts, list[bytes]()

    def add(self, tape: Tape, rows: Sequence[int], inputs: Sequence[int], kind: str = "robot") -> dict[str, Json]:
        """Add a module; return its number, the kind of its parameters, and the numbers of its inputs and outputs."""
        inputs = [*inputs, self.counts[kind]]
        self.modules.append(wasm_module(tape, rows, inputs))
        return {"module": len(self.modules) - 1, "kind": kind, "inputs": sum(inputs), "outputs": len(rows)}


class PageRobot:
    """One of the robots of a page, with the pose and loads of its result.

    Attributes:
        lines: prescribed coordinates of platform and actuators, by kind.
        parts: its data from which programs are recorded, by kind of line, and for all other programs.
        structures: these data, separated into structure and numbers.
    """

    def __init__(self, result: Result, coordinates: Sequence[str]) -> None:
        self.result, self.robot, self.convention = result, result.robot, result.configuration.orientation
        robot, given = self.robot, {"actuators": self.robot.actuator_coordinates}
        if coordinates:
            given["platform"] = prescribed_platform(tuple(coordinates), self.convention)
        self.lines = {kind: robot.mobility_analysis.with_dofs(line) for kind, line in given.items() if line.size}
        self.parts: dict[str, object] = {kind: (robot.solver, line) for kind, line in self.lines.items()}
        self.parts["robot"] = robot, generic_forces(robot)
        self.structures = {kind: Structure(part, all_vary=True, whole=True) for kind, part in self.parts.items()}

    @cached_property
    def _drawn(self) -> tuple[list[Mesh], float]:
        return meshes_of(self.result)

    @property
    def size(self) -> float:
        """Size of the drawn robot [m]."""
        return self._drawn[1]

    @cached_property
    def meshes(self) -> list[tuple[dict[str, object], str]]:
        """The meshes as data for JSON: each without its shape, and its shape as JSON."""
        every = [mesh.plain() for mesh in self._drawn[0]]
        shapes = [json.dumps({key: mesh.pop(key) for key in ("vertices", "copies", "faces")}) for mesh in every]
        return list(zip(every, shapes, strict=True))

    @cached_property
    def limits(self) -> dict[str, list[float | None]]:
        """Limits of joints with one freedom, and of cones; None for infinite ones."""
        limited = self.robot.joint_coordinates.limited(self.robot.model_q(self.robot.zero_poses), self.robot.zero_frames)
        return {name: [end if np.isfinite(end) else None for end in ends] for name, _, ends, _ in limited}

    @cached_property
    def sections(self) -> dict[str, dict[str, object]]:
        """Stresses of the beams with known outlines, see :meth:`Section.forms`."""
        beams = self.robot.description.beams.items()
        forms = {name: self.robot.beams[name].section.forms(beam.poisson_ratio) for name, beam in beams}
        return {name: {"forms": packed(of[0], "<f8"), "rings": of[1]} for name, of in forms.items() if of is not None}

    def copy(self, tape: Tape, varying: Mask) -> tuple[Robot, list[Array]]:
        """Return the robot and its usual forces, see :func:`.generic_forces`, with parameters recorded on a tape."""
        robot, usual = Structure(self.parts["robot"], tape, varying=varying, whole=True).copy
        for name, beam in robot.beams.items():
            vars(beam)["section"] = self.robot.beams[name].section  # stresses are not recorded
        return robot, usual

    def is_like(self, other: PageRobot) -> bool:
        """Whether the two differ in numbers only, and in the shapes of their meshes."""
        alike = all(structure.key == other.structures[kind].key for kind, structure in self.structures.items())
        return alike and [mesh for mesh, _ in self.meshes] == [mesh for mesh, _ in other.meshes]

    def programs(
        self, varying: Mapping[str, Mask], size: float | None, by_mechanism: bool
    ) -> tuple[dict[str, object], list[bytes]]:
        """Return the programs of the page, and their modules.

        Args:
            varying: True for those numbers of :attr:`structures` that are inputs.
            size: size of the drawn robot [m], see :func:`.scene_of`.
        """
        example = self.robot.generic_poses.take(np.array([0]))
        code = _Code({kind: int(np.sum(mask)) for kind, mask in varying.items()})
        lines = {kind: _line(self.robot, line, example, varying[kind], kind, code) for kind, line in self.lines.items()}
        closed = _closed(self, varying["robot"], example, code)
        statics = _statics(self, varying["robot"], example, size, by_mechanism, code)
        return {"lines": lines, "closed": closed, "statics": statics}, code.modules

    def numbers(self, varying: Mapping[str, Mask]) -> dict[str, object]:
        """Return what differs between the robots of a page, except shapes of meshes."""
        robot = self.robot
        return {
            "values": {kind: packed(self.structures[kind].values[mask], "<f8") for kind, mask in varying.items()},
            "zero": {"x": robot.zero_poses.x[:, 0].tolist(), "c": robot.zero_poses.c[:, 0].tolist()},
            "length": robot.length, "size": robot.size, "rough": robot.rough_residual, "warnings": [*robot.warnings],
            "efforts": [
                [name, limit, robot.mechanism.connections[name].type.force_unit]
                for name, limit in robot.description.actuator_limits("effort").items()
            ],
            "limits": self.limits,
            "lines": {
                kind: {"longest": longest_strides(robot.solver, line).tolist(), "impose": [*_imposed(robot, line)]}
                for kind, line in self.lines.items()
            },
            "sections": self.sections,
        }  # fmt: skip


# ---- loops ---------------------------------------------------------------------------------------------------------------


def _line(
    robot: Robot, prescribed: PrescribedCoordinates, example: SolverState, varying: Mask, kind: str, code: _Code
) -> dict[str, object]:
    """Return the programs that follow straight lines of prescribed coordinates, and their data."""
    example = SolverState(example.x, robot.solver.origin(prescribed, example)[1])
    nq, n = len(example.x), prescribed.size

    def added(record: Callable[..., Program], *inputs: int) -> dict[str, Json]:
        program = record(robot.solver, prescribed, example, varying)
        return code.add(program.tape, (*program.numbers, *program.truths), inputs, kind)

    return {
        "names": robot.actuator_names if kind == "actuators" else _names(prescribed),
        "idle": robot.actuators_outside_limbs,
        "turns": turns(robot.solver, prescribed).tolist(),
        "newton": added(newton_record, nq + 8, n + 1),
        "side": None if prescribed.local_dofs else added(side_record, nq, 3, nq, 3),
        "start": added(start_record, nq, 3, n, 1),
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


def _closed(page_robot: PageRobot, varying: Mask, example: SolverState, code: _Code) -> dict[str, object]:
    """Return the program of a closed pose: errors of the loops, coordinates, and which joints are within their limits."""
    tape, zero, convention = Tape(), np.zeros((6, 1)), page_robot.convention
    robot, _ = page_robot.copy(tape, varying)
    outputs, limits = _Outputs(tape), []
    with recording():
        pose = Pose(PoseModel(robot.joint_coordinates, robot.statics), recorded_input(tape, 0, example.x), zero, zero[:3])
        R, o = robot.mechanism.platform_pose(pose.frames)
        places: dict[str, object] = {
            "rough": outputs.add(np.max(np.abs(pose.closures), axis=0, initial=0.0)),
            "opening": outputs.add(pose.opening()),
            "actuators": outputs.add(pose.actuators()),
            "platform": outputs.add(np.concatenate([o, convention.coordinates(R)])),
        }
        ends = page_robot.limits
        for name, value, _, within in robot.joint_coordinates.limited(pose.placed.q, pose.frames):
            slides = robot.mechanism.connections[name].type.is_slide
            joint = {"name": name, "slides": slides, "value": outputs.add(value)}
            if ends[name] != [None, None]:
                limits.append({**joint, "within": outputs.add(within)})
        places["holds"] = outputs.add(tape.holds())
    names = {"actuators": list(robot.description.actuated), "platform": convention.pose_names}
    return {**code.add(tape, outputs.rows, [len(example.x)]), "places": places, "limits": limits, "names": names}


# ---- statics and drawing -------------------------------------------------------------------------------------------------


def _statics(
    page_robot: PageRobot, varying: Mask, example: SolverState, size: float | None, by_mechanism: bool, code: _Code
) -> dict[str, object]:
    """Return the program of the equilibrium and of its drawing."""
    result, payload, tape = page_robot.result, page_robot.result.payload, Tape()
    robot, usual = page_robot.copy(tape, varying)
    examples = example.x, *example_of(page_robot.robot.statics)[1:], np.array([_EXAMPLE_PAYLOAD]).T
    outputs = _Outputs(tape)
    with recording():
        x, load, gravity, mass = (recorded_input(tape, number, array) for number, array in enumerate(examples))
        pose = Pose(PoseModel(robot.joint_coordinates, robot.statics), x, load, gravity)
        given = parse_link_loads(robot.statics, result.loads, Payload(1.0, link=None if payload is None else payload.link))
        assert given is not None
        *others, last = given.map(lambda array: array[..., None]).loads
        applied = replace(given, loads=(*others, replace(last, point=mass[1:], mass=mass[:1]))).at(pose.frames, gravity)
        solution = pose.under(applied)
        shown = _recorded_result(result, robot, pose, split(robot.statics, solution) if by_mechanism else solution)
        values = {name: outputs.add(OF_EQUILIBRIUM[name](robot.statics, solution)) for name in _VALUES}
        # what is drawn: computed here, where conditions become guards
        for name in ("beam_contributions", "link_contributions", "actuator_contributions", "base_wrench", "joint_wrenches"):
            getattr(shown, name)
        values["holds"] = outputs.add(tape.holds())
        values["regular"] = outputs.add(are_regular(robot, solution, usual))
        if not robot.description.springs:
            values["bound"] = outputs.add(estimate(robot.members.structure, solution))
        with deciding_by_example():
            for results in shown.beams.values():  # eigenvalues are not recorded
                vars(results._euler_ratio)["of_beams"] = dict.fromkeys(robot.beams, np.full((), np.nan))
            drawn = _RecordedPose(shown)
            scene = scene_of(drawn, link_visuals(page_robot.robot.description), size=size)
            for name in robot.beams:
                scene.cards[f"beams/{name}"] = _without_stress(scene.cards[f"beams/{name}"])
            template: dict[str, Json] = {**scene.moving(outputs), **scene.details(outputs)}
            template["on_links"] = {name: outputs.path(wrench) for name, wrench in wrenches_on_links(drawn, scene.size).items()}
    for name in page_robot.sections:  # the page computes their stresses
        card = template["cards"][f"beams/{name}"]
        card |= {"section": name, "stress_row": [row["words"] for row in card["rows"]].index(LARGEST_STRESS)}
    program = code.add(tape, outputs.rows, [len(array) for array in examples])
    firsts = [card["first"] for path, card in template["cards"].items() if path.startswith("beams/")]
    return {**program, "places": values, "template": template, "beams": firsts if drawn.every > 1 else []}


def _without_stress(card: Card) -> Card:
    unknown = np.full(1, np.nan)
    rows = [replace(row, values=unknown) if row.words == LARGEST_STRESS else row for row in card.rows]
    return replace(card, rows=rows, lines={**card.lines, "stress": unknown[:, None]})


#: Outputs of the equilibrium by which the page judges a pose, and which it returns to scripts.
_VALUES = ("twist", "actuator_forces", "stiffness", "singular", "indeterminate", "basis_degenerate", "doubtful")


def _recorded_result(result: Result, robot: Robot, pose: Pose, solution: Solution) -> Result:
    one = np.ones(1, dtype=bool)
    configuration = replace(
        result.configuration, robot=robot, poses=SolverState(pose.x, np.zeros((3, 1))), model_q=pose.placed.q, frames=pose.frames,
        loop_residual=pose.placed.residual, reached=one,
    )  # fmt: skip
    recorded = Result(configuration, (), slice(None), (Chunk(robot, [solution]),), one)
    vars(recorded)["_valid"] = one
    return recorded
