"""Derivatives in C: what :meth:`kinetostatics.functions.function.Function.jacobian` gives, by one input after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.engine.c_code import CProgram, c_program
from kinetostatics.engine.derivatives import tangent_record
from kinetostatics.engine.loop_record import motion_record, rates_record, structure_of
from kinetostatics.engine.outputs import OutputRecord
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.values import LOADS, Facts, Quantity
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.kinematics.velocities import body_moves
from kinetostatics.math.arrays import Array
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class JacobianPrograms:
    """All programs of derivatives.

    ``rates`` takes x and c and gives how fast the freedoms move with each coordinate; ``motion`` takes x, frames and such rates,
    and gives how fast frames and actuators move; ``tangent`` takes frames, load and gravity and their rates, and gives how fast
    the results change.

    Attributes:
        freedoms: how many there are.
        bodies: how many there are.
        rows: where each output's rates stand among the results of ``tangent``; actuators among those of ``motion``.
        pairs: names of outputs and inputs, how many components each has, and the name of their field.
    """

    rates: CProgram
    motion: CProgram
    tangent: CProgram
    freedoms: int
    bodies: int
    rows: Mapping[str, int]
    pairs: Sequence[tuple[Quantity, Quantity, str]]

    @property
    def programs(self) -> tuple[CProgram, ...]:
        """All of them."""
        return self.rates, self.motion, self.tangent


def jacobian_programs(
    robot: Robot,
    prescribed: PrescribedCoordinates,
    example: SolverState,
    local: int,
    record: OutputRecord,
    numbers: Array,
    pairs: Sequence[tuple[Quantity, Quantity, str]],
) -> JacobianPrograms:
    """Record derivatives.

    Args:
        robot: the robot.
        prescribed, example, local: coordinates that are given, see :func:`rates_record`.
        record, numbers: of the statics, which grows, and the robot's numbers that it takes.
        pairs: outputs and inputs, and the names of their fields.
    """
    solver, given = robot.solver, robot.actuator_coordinates
    frames = solver.place(example.x).frames
    bodies = frames.position.shape[1]
    rates = rates_record(solver, prescribed, example, local)
    motion = motion_record(solver, given, body_moves(solver), (example, frames), local)
    names = list(dict.fromkeys(output.name for output, _, _ in pairs if output.name != "actuators"))
    starts = np.cumsum([0, *(len(record.rows[name]) for name in names)]).tolist()
    wanted = tangent_record(record.tape, [row for name in names for row in record.rows[name]], 4)

    of_motion = ("x", 0), ("frames", 0), ("frames", 9 * bodies), ("v", 0)
    of_statics = ("frames", 0), ("frames", 9 * bodies), ("load", 0), ("gravity", 0)
    of_tangent = *of_statics, *((f"d_{name}", first) for name, first in of_statics)
    held = ("frames", "load", "gravity")
    return JacobianPrograms(
        c_program(
            "rates",
            rates.tape,
            (*rates.numbers, *rates.truths),
            structure_of(solver, prescribed, local).values,
            ("x", "c"),
        ),
        c_program(
            "motion", motion.tape, motion.numbers, structure_of(solver, given, local).values, ("x", "frames", "v"), of_motion
        ),
        c_program("tangent", record.tape, wanted, numbers, (*held, *(f"d_{name}" for name in held)), of_tangent),
        solver.tree.nv,
        bodies,
        dict(zip(names, starts, strict=False)) | {"actuators": 12 * bodies},
        pairs,
    )


def pairs_of(
    outputs: Mapping[str, Quantity],
    inputs: Mapping[str, Quantity],
    c_names: Mapping[str, str],
    of: Sequence[str],
    by: Sequence[str],
) -> list[tuple[Quantity, Quantity, str]]:
    """Return outputs and inputs, and the names of the fields that have derivatives of one by the other.

    Raises:
        ArgumentError: something that a derivative is taken by is no input.
    """
    for name in by:
        if name not in inputs:
            raise ArgumentError(f"derivatives by {name!r} are not exported, those by inputs are: {', '.join(inputs)}")
    return [(outputs[a], inputs[b], f"{a}_by_{c_names.get(b, b)}") for a in of for b in by]


def size(item: Quantity) -> int:
    """Return how many numbers it has."""
    return int(np.prod(item.shape))


def header(name: str, scalar: str, facts: Facts) -> str:
    """Return what the header says of derivatives."""
    fields = []
    for output, value, field in facts["parts"].jacobian.pairs:
        shape = " x ".join(str(n) for n in (*output.shape, *value.shape))
        fields.append(f"    {scalar} {field}[{size(output) * size(value)}]; /* {shape}, row by row */")
    return f"""
/* Derivatives of outputs by inputs, with the loops kept closed. */
typedef struct {{
{chr(10).join(fields)}
}} {name}_jacobian;

/* As {name}_evaluate, and the derivatives there; they are NaN where the status is not OK. */
int {name}_differentiate(
    const {name}_input *input, {name}_state *state, {name}_output *output, {name}_jacobian *jacobian);
"""


def source(name: str, scalar: str, facts: Facts) -> str:
    """Return the function that computes derivatives."""
    parts = facts["parts"]
    programs: JacobianPrograms = parts.jacobian
    bodies, freedoms, actuators = programs.bodies, programs.freedoms, len(parts.actuator_order)
    lost = [
        f"    for (k = 0; k < {size(output) * size(value)}; ++k) jacobian->{field}[k] = ({scalar})NAN;"
        for output, value, field in programs.pairs
    ]
    blocks = []
    for value in dict.fromkeys(pair[1] for pair in programs.pairs):
        columns, moves = size(value), value.name not in LOADS
        if moves:
            row = facts["controlled"].index(value.name)
            setting = [f"    motion(state->x, frame, v + {row * freedoms}, w, d_frame);", "    k = 0;"]
        else:
            setting = [
                "    memset(d_frame, 0, sizeof d_frame);",
                f"    for (k = 0; k < {columns}; ++k) {{",
                f"    d_{value.name}[k] = 1.0;",
            ]
        taken = []
        for output, other, field in programs.pairs:
            if other is not value:
                continue
            if output.name == "actuators":
                for k, place in enumerate(parts.actuator_order):
                    found = f"({scalar})d_frame[{12 * bodies + place}]" if moves else "0"
                    taken.append(f"    jacobian->{field}[{k * columns} + k] = {found};")
            else:
                at = programs.rows[output.name]
                taken.append(
                    f"    for (i = 0; i < {size(output)}; ++i) jacobian->{field}[i * {columns} + k] = ({scalar})rate[{at} + i];"
                )
        ending = [] if moves else [f"    d_{value.name}[k] = 0.0;", "    }"]
        call = "    tangent(frame, load, gravity, d_frame, d_load, d_gravity, w, rate);"
        blocks += [*setting, call, *taken, *ending]
    rows = sum(size(output) for output in dict.fromkeys(pair[0] for pair in programs.pairs))
    return f"""
int {name}_differentiate(
    const {name}_input *input, {name}_state *state, {name}_output *output, {name}_jacobian *jacobian)
{{
    double w[WORK], v[{freedoms} * NT + 1], frame[{parts.frame_numbers + parts.closures + 1}], load[6], gravity[3];
    double d_frame[{12 * bodies + actuators}], d_load[6] = {{0.0}}, d_gravity[3] = {{0.0}}, rate[{rows + 1}];
    int i, k, status;
    if (!jacobian) return {name.upper()}_BAD_ARGUMENT;
{chr(10).join(lost)}
    status = {name}_evaluate(input, state, output);
    if (status != {name.upper()}_OK) return status;
    for (k = 0; k < 6; ++k) load[k] = (double)input->load[k];
    for (k = 0; k < 3; ++k) gravity[k] = (double)input->gravity[k];
    frames(state->x, w, frame);
    rates(state->x, state->c, w, v);
    if (v[{freedoms} * NT] == 0.0) return {name.upper()}_NOT_COVERED;
    (void)i;
{chr(10).join(blocks)}
    return status;
}}
"""
