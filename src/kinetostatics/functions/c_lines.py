"""What follows a straight line of coordinates in C, those of a function or those of the actuators, by recorded programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.engine.c_code import CProgram, c_program, literal
from kinetostatics.engine.loop_record import Program, line_record, newton_record, side_record, structure_of
from kinetostatics.functions.values import Facts
from kinetostatics.kinematics.lines import longest_strides
from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import TreeJoint
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class CLine:
    """What follows lines of some coordinates.

    Attributes:
        prefix: what the names of its functions in C begin with.
        prescribed: the coordinates.
        local: number of freedoms that do not move the platform; they stay as they are.
        constants: the numbers that records of these coordinates take.
        newton, side: a correction, and whether there is a singular pose between two; None: that is not looked at.
        start: the coordinates where a line starts, if several mean the same.
        impose: lines of C that write given coordinates into ``x`` and ``c``.
        strides: (n,) how far the coordinates may go in one step.
    """

    prefix: str
    prescribed: PrescribedCoordinates
    local: int
    constants: Array
    newton: CProgram
    side: CProgram | None
    start: CProgram | None
    impose: tuple[str, ...]
    strides: Array

    @property
    def programs(self) -> list[CProgram]:
        """All programs, in the order in which they are written."""
        return [item for item in (self.start, self.newton, self.side) if item is not None]


def line_of(robot: Robot, given: PrescribedCoordinates, prefix: str = "") -> CLine:
    """Record what follows lines of given coordinates."""
    prescribed = robot.mobility_analysis.without_idle_dofs(given)
    solver, local = robot.solver, robot.mobility_analysis.local_dofs(prescribed)
    example = example_of(robot, prescribed)
    constants = structure_of(solver, prescribed, local).values
    newton = of_program(f"{prefix}newton", newton_record(solver, prescribed, example, local), constants, ("state", "given"))
    side = start = None
    if not local:
        inputs = ("x1", "c1", "x2", "c2")
        side = of_program(f"{prefix}side", side_record(solver, prescribed, example, local), constants, inputs)
    if prescribed.angles:
        line = line_record(prescribed, solver.values(prescribed, example), example.c)
        start = of_program(f"{prefix}line", line, np.array([]), ("first", "angles", "aim", "shorter"))
    impose = tuple(_imposed(robot, prescribed))
    return CLine(prefix, prescribed, local, constants, newton, side, start, impose, longest_strides(solver, prescribed))


def example_of(robot: Robot, prescribed: PrescribedCoordinates) -> SolverState:
    """Return the pose at which records are made."""
    generic = robot.generic_poses.take(np.array([0]))
    return SolverState(generic.x, robot.solver.origin(prescribed, generic)[1])


def of_program(name: str, program: Program, constants: Array, inputs: tuple[str, ...]) -> CProgram:
    """Return a record in C."""
    return c_program(name, program.tape, (*program.numbers, *program.truths), constants, inputs)


def _imposed(robot: Robot, prescribed: PrescribedCoordinates) -> Iterator[str]:
    """Yield lines of C that write given coordinates into x and c; see :meth:`Solver.impose`."""
    for row, column in enumerate(prescribed.columns):
        yield from _written(robot.solver.joint_of_column[column], f"target[{row}]")
    for item in robot.equations.couplings.items:
        if item.leader.first_v in prescribed.columns:
            row = prescribed.columns.index(item.leader.first_v)
            yield from _written(item.follower, f"({literal(item.multiplier)} * target[{row}] + {literal(item.offset)})")
    for row, k in enumerate(prescribed.angles):
        yield f"c[{k}] = target[{prescribed.first_angle + row}];"


def _written(joint: TreeJoint, value: str) -> Iterator[str]:
    if joint.type.endless:
        yield f"x[{joint.first_q}] = cos({value});"
        yield f"x[{joint.first_q + 1}] = sin({value});"
    else:
        yield f"x[{joint.first_q}] = {value};"


def c_array(values: Sequence[float] | Array) -> str:
    """Return an array as C spells it; there is none without entries."""
    return "{" + ", ".join(literal(float(value)) for value in values) + "}" if len(values) else "{0.0}"


def source(name: str, facts: Facts, line: CLine) -> str:
    """Return the C functions that follow a line and put a pose on it right; ``frames`` stands before them."""
    parts, pre, nt = facts["parts"], line.prefix, line.prescribed.size
    side = (
        f"    {pre}side(first->x, first->c, second->x, second->c, w, &sure);\n    return sure != 0.0;"
        if line.side is not None
        else "    (void)first; (void)second; (void)w; (void)sure;\n    return 1; /* freedoms that move no platform are left */"
    )
    return f"""static const double {pre}LONGEST[{max(nt, 1)}] = {c_array(line.strides)}; /* of a line in one go */

static void {pre}impose(const double *target, double *x, double *c)
{{
    (void)target; (void)x; (void)c;
{chr(10).join(f"    {text}" for text in line.impose)}
}}

/* Newton's method from a pose to a target beside it; returns whether it converged steadily. */
static int {pre}corrected({name}_state *pose, const double *target, int passing, double *w)
{{
    double state[NX + 8], given[{nt + 1}], next[NX + 9];
    int k;
    memcpy(given, target, {nt} * sizeof(double));
    given[{nt}] = passing ? 1.0 : 0.0;
    {pre}impose(target, pose->x, pose->c);
    memcpy(state, pose->x, NX * sizeof(double));
    memcpy(state + NX, pose->c, 3 * sizeof(double));
    state[NX + 3] = (double)INFINITY;
    state[NX + 4] = {literal(facts["shrinking"])};
    state[NX + 5] = 1.0;
    state[NX + 6] = 0.0;
    state[NX + 7] = 1.0;
    for (k = 0; k < MOST_CORRECTIONS && state[NX + 5] != 0.0; ++k) {{
        {pre}newton(state, given, w, next);
        ++pose->corrections;
        memcpy(state, next, sizeof state);
    }}
    memcpy(pose->x, state, NX * sizeof(double));
    memcpy(pose->c, state + NX, 3 * sizeof(double));
    return state[NX + 6] != 0.0 && state[NX + 7] != 0.0;
}}

/* Whether there is surely no singular pose between two poses. */
static int {pre}on_one_side(const {name}_state *first, const {name}_state *second, double *w)
{{
    double sure = 0.0;
{side}
}}

/* Follow the straight line from coordinates of a pose, which go with it, to others; returns whether the end was reached. */
static int {pre}followed({name}_state *pose, double *at, const double *target, double *w)
{{
    double gone = 0.0, far = 0.0, longest, stride, first[{nt + 1}], goal[{nt + 1}];
    {name}_state moved;
    int steady = 1, k, steps;
    memcpy(first, at, {nt} * sizeof(double));
{_line_start(facts, line)}    for (k = 0; k < {nt}; ++k) {{
        const double part = fabs(target[k] - first[k]) / {pre}LONGEST[k];
        if (part > far) far = part;
    }}
    longest = far > 1.0 ? 1.0 / far : 1.0;
    stride = longest;
    for (steps = 0; steps < {name.upper()}_MOST_STEPS; ++steps) {{
        const double trial = gone + stride < 1.0 ? gone + stride : 1.0;
        int good;
        for (k = 0; k < {nt}; ++k) goal[k] = first[k] + trial * (target[k] - first[k]);
        if (trial >= 1.0) memcpy(goal, target, {nt} * sizeof(double));
        moved = *pose;
        good = {pre}corrected(&moved, goal, trial < 1.0, w) && {pre}on_one_side(pose, &moved, w);
        if (good) {{
            *pose = moved;
            memcpy(at, goal, {nt} * sizeof(double));
            gone = trial;
            pose->moved = 1.0;
            if (gone >= 1.0) return 1;
            if (steady) stride = 2.0 * stride < longest ? 2.0 * stride : longest;
        }} else {{
            pose->corrections = moved.corrections;
            stride /= 2.0;
            if (stride <= 1e-3 * longest) return 0;
        }}
        steady = good;
    }}
    return 0;
}}

/* The frames of a pose, put right if its last correction was not quite as small as expected; tells how far loops are open. */
static void {pre}closed({name}_state *pose, const double *at, double *w, double *frame, double *worst)
{{
    int again, k;
    for (again = 0; again < 2; ++again) {{
        frames(pose->x, w, frame);
        *worst = 0.0;
        for (k = 0; k < {parts.closures}; ++k) {{
            const double open = fabs(frame[{parts.frame_numbers} + k]);
            if (open > *worst) *worst = open;
        }}
        if (again || !(*worst > {literal(facts["rough"])})) break;
        (void){pre}corrected(pose, at, 0, w);
    }}
}}
"""


def _line_start(facts: Facts, line: CLine) -> str:
    """Return what makes the coordinates where a line starts those that are nearest to its end, where several mean the same."""
    if line.start is None:
        return ""
    unsure = " || ".join(f"!(fabs(pose->c[{k}]) < {facts['unique_below']})" for k in range(3))
    nt = line.prescribed.size
    return f"""    if ({unsure}) {{
        double begin[{nt + 4}];
        {line.prefix}line(first, pose->c, target, &pose->moved, w, begin);
        if (begin[{nt + 3}] != 0.0) {{
            memcpy(first, begin, {nt} * sizeof(double));
            memcpy(pose->c, begin + {nt}, 3 * sizeof(double));
        }}
    }}
"""
