"""Source file of the exported C; see :mod:`kinetostatics.functions.c_export`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinetostatics.compensation import MOST
from kinetostatics.engine.c_code import literal
from kinetostatics.functions.c_names import c_comment
from kinetostatics.functions.c_programs import CJacobian, Line, Programs
from kinetostatics.functions.inputs_outputs import LOADS, Quantity
from kinetostatics.kinematics.solver import MOST_CORRECTIONS, SHRINKING
from kinetostatics.math.arrays import Array
from kinetostatics.math.rotations import orientation_named


def c_array(values: Sequence[float] | Array) -> str:
    return "{" + ", ".join(literal(float(value)) for value in values) + "}" if len(values) else "{0.0}"


def size(quantity: Quantity) -> int:
    return int(np.prod(quantity.shape))


def valid(name: str, parts: Programs, status: str) -> str:
    """Return a C expression that is true if the outputs are valid at the status ``status``."""
    expression = f"{status} == {name.upper()}_OK"
    return f"{expression} || {status} == {name.upper()}_LIMIT_EXCEEDED" if parts.function.compensates else expression


def source(name: str, scalar: str, parts: Programs) -> str:
    function = parts.function
    nx, nt = len(parts.start[0]), len(parts.start[2])
    coordinates = [f"    target[{k}] = (double)input->{parts.c_names[name]};" for k, name in enumerate(function.names)]
    results, lost = [], ["    int k;"] if parts.outputs else []
    for quantity in parts.outputs:
        loop = f"    for (k = 0; k < {size(quantity)}; ++k) output->{quantity.name}[k] = ({scalar})"
        if function.compensates and quantity.name in ("actuators", "residual_error"):
            results.append(f"{loop}{quantity.name}[k];")
        else:
            results.append(f"{loop}result[{parts.at[quantity.name]} + k];")
        lost.append(f"{loop}NAN;")
    if parts.efforts:
        exceeded = " || ".join(
            f"fabs((double)output->actuator_forces[{k}]) > {literal(most)}" for k, most in parts.efforts.items()
        )
        results.append(f"    output->effort_exceeded = {exceeded} ? ({scalar})1 : ({scalar})0;")
        lost.append(f"    output->effort_exceeded = ({scalar})NAN;")
    lines = [parts.line, *([] if parts.drives is None else [parts.drives])]
    more = f"    double residual_error[6], actuators[{max(len(parts.order), 1)}];\n" if function.compensates else ""
    return f"""/* {c_comment(function.robot.name)}: written by kinetostatics; see {name}.h. */
#include "{name}.h"

#include <math.h>
#include <string.h>

enum {{ NX = {nx}, NT = {nt}, RESULTS = {parts.at["holds"] + 1}, WORK = {parts.work} }};
enum {{ MOST_CORRECTIONS = {MOST_CORRECTIONS} }};
#ifndef {name.upper()}_MOST_STEPS
#define {name.upper()}_MOST_STEPS 200 /* of a line, including steps that are repeated with half the length */
#endif

static const double START_X[{max(nx, 1)}] = {c_array(parts.start[0])};
static const double START_C[3] = {c_array(parts.start[1])};
static const double START_TARGET[{max(nt, 1)}] = {c_array(parts.start[2])};

{chr(10).join(program.text for _, program in parts.all)}
{chr(10).join(_following(name, parts, line) for line in lines)}{_compensated(name, parts) if function.compensates else ""}
static void lost({name}_output *output)
{{
{chr(10).join(lost)}
    output->residual = ({scalar})NAN;
}}

void {name}_start({name}_state *state)
{{
    memcpy(state->x, START_X, sizeof state->x);
    memcpy(state->c, START_C, sizeof state->c);
    memcpy(state->target, START_TARGET, sizeof state->target);
    state->moved = {0.0 if parts.from_zero else 1.0};
    state->corrections = 0;
}}

int {name}_evaluate(const {name}_input *input, {name}_state *state, {name}_output *output)
{{
    double w[WORK], target[NT + 1], load[6], gravity[3], result[RESULTS];
{more}    {name}_state pose;
    int k, status;
    if (!input || !state || !output) return {name.upper()}_BAD_ARGUMENT;
    lost(output);
{chr(10).join(coordinates)}
    for (k = 0; k < 6; ++k) load[k] = (double)input->load[k];
    for (k = 0; k < 3; ++k) gravity[k] = (double)input->gravity[k];
    for (k = 0; k < NT; ++k) if (!isfinite(target[k])) return {name.upper()}_BAD_ARGUMENT;
    for (k = 0; k < 6; ++k) if (!isfinite(load[k])) return {name.upper()}_BAD_ARGUMENT;
    for (k = 0; k < 3; ++k) if (!isfinite(gravity[k])) return {name.upper()}_BAD_ARGUMENT;
    pose = *state;
    if (!followed(&pose, pose.target, target, w)) return {name.upper()}_UNREACHABLE;
    status = analysed(&pose, pose.target, load, gravity, w, result);
    *state = pose;
    if (status != {name.upper()}_OK) return status;
{_correction(name, parts) if function.compensates else ""}{chr(10).join(results)}
    output->residual = ({scalar})result[{parts.at["worst_equation"]}];
    return status;
}}
{"" if parts.jacobian is None else _differentiate(name, scalar, function.names, parts.jacobian)}"""


# ---- lines of coordinates, and poses where they end ----------------------------------------------------------------------


def _following(name: str, parts: Programs, line: Line) -> str:
    """Return the C functions that follow a line of coordinates and analyse the pose at its end."""
    pre, nt, at = line.prefix, line.prescribed.size, parts.at
    side = (
        f"    {pre}side(first->x, first->c, second->x, second->c, w, &sure);\n    return sure != 0.0;"
        if line.side is not None
        else "    (void)first; (void)second; (void)w; (void)sure;\n    return 1; /* local freedoms: no test for singular poses */"
    )
    return f"""static const double {pre}LONGEST[{max(nt, 1)}] = {c_array(line.longest_steps)}; /* step of a line */

static void {pre}impose(const double *target, double *x, double *c)
{{
    (void)target; (void)x; (void)c;
{chr(10).join(f"    {text}" for text in line.impose)}
}}

/* Newton's method from a pose to a nearby target; returns whether every correction was smaller than the one before. */
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
    state[NX + 4] = {literal(SHRINKING)};
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

/* Whether it is certain that there is no singular pose between two poses. */
static int {pre}on_one_side(const {name}_state *first, const {name}_state *second, double *w)
{{
    double sure = 0.0;
{side}
}}

/* Follow the straight line from the coordinates "at" of a pose to a target, and update both; returns whether it arrived. */
static int {pre}followed({name}_state *pose, double *at, const double *target, double *w)
{{
    double gone = 0.0, far = 0.0, longest, stride, first[{nt + 1}], goal[{nt + 1}];
    {name}_state moved;
    int steady = 1, k, steps;
    memcpy(first, at, {nt} * sizeof(double));
{_line_start(parts, line)}    for (k = 0; k < {nt}; ++k) {{
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

/* Analyse a pose, after further corrections if its loops are not closed accurately enough; returns the status. */
static int {pre}analysed(
    {name}_state *pose, const double *at, const double *load, const double *gravity, double *w, double *result)
{{
    analysis(pose->x, load, gravity, w, result);
    if (result[{at["worst_equation"]}] > {literal(parts.function.robot.rough_residual)}) {{
        (void){pre}corrected(pose, at, 0, w);
        analysis(pose->x, load, gravity, w, result);
    }}
    if (result[{at["holds"]}] == 0.0) return {name.upper()}_NOT_COVERED;
    if (result[{at["singular"]}] != 0.0) return {name.upper()}_SINGULAR;
    return result[{at["usual"]}] == 0.0 ? {name.upper()}_NOT_COVERED : {name.upper()}_OK;
}}
"""


def _line_start(parts: Programs, line: Line) -> str:
    """Return C code that chooses, among equivalent coordinates at the start of a line, those nearest to the line's end."""
    if line.start is None:
        return ""
    unique_below = orientation_named(parts.function.orientation).unique_below
    unsure = " || ".join(f"!(fabs(pose->c[{k}]) < {unique_below})" for k in range(3))
    nt = line.prescribed.size
    return f"""    if ({unsure}) {{
        double begin[{nt + 4}];
        {line.prefix}line(pose->x, pose->c, target, &pose->moved, w, begin);
        if (begin[{nt + 3}] != 0.0) {{
            memcpy(first, begin, {nt} * sizeof(double));
            memcpy(pose->c, begin + {nt}, 3 * sizeof(double));
        }}
    }}
"""


# ---- compensation --------------------------------------------------------------------------------------------------------


def _compensated(name: str, parts: Programs) -> str:
    """Return the C function that searches for the commanded pose of the unloaded robot."""
    search, at, n = parts.search, parts.at, len(parts.order)
    assert search is not None
    numbers, first = search.numbers, at["actuators"]
    order = "\n".join(
        f"    before[{place}] = at_target[{k}]; after[{place}] = actuators[{k}];" for k, place in enumerate(parts.order)
    )
    return f"""
/* Search for the commanded pose at which the loaded platform has its target pose: Broyden's method, from the target pose and the
 * twist there; each of its steps follows a line. Then the actuators move along a straight line from the target pose to the
 * positions found, to check that no singular pose is between them and that the platform arrives. */
static int compensated(
    {name}_state *pose, const double *load, const double *gravity, double *w, double *result, double *residual_error,
    double *actuators)
{{
    double target_frame[12], search[{numbers + 1}], next[{numbers + 1}], left[7], actuated_result[RESULTS];
    double at_target[{n + 1}], before[{n + 1}], after[{n + 1}];
    const double *const frame = result + {at["platform"]}, *const twist = result + {at["twist"]};
    {name}_state actuated = *pose;
    int k;
    memcpy(at_target, result + {first}, {n} * sizeof(double));
    memcpy(target_frame, frame, sizeof target_frame);
    begin(target_frame, twist, w, search);
    if (search[{numbers}] == 0.0) return {name.upper()}_NOT_COVERED;
    for (k = 0; k < {MOST} && search[{search.continues}] != 0.0; ++k) {{
        int status;
        if (!followed(pose, pose->target, search, w)) return {name.upper()}_UNREACHABLE;
        status = analysed(pose, pose->target, load, gravity, w, result);
        if (status != {name.upper()}_OK) return status == {name.upper()}_SINGULAR ? {name.upper()}_UNREACHABLE : status;
        update(search, frame, twist, w, next);
        if (next[{numbers}] == 0.0) return {name.upper()}_NOT_COVERED;
        memcpy(search, next, sizeof search);
    }}
    if (!(search[{search.largest_error}] <= {literal(search.tolerance)})) return {name.upper()}_UNREACHABLE;
    remaining(target_frame, frame, twist, w, left);
    memcpy(residual_error, left, 6 * sizeof(double));
    if (left[6] == 0.0) return {name.upper()}_NOT_COVERED;
    correct(at_target, result + {first}, w, before);
    memcpy(actuators, before, {n} * sizeof(double));
{order}
    actuated.corrections = pose->corrections;
    k = actuated_followed(&actuated, before, after, w);
    pose->corrections = actuated.corrections;
    if (!k) return {name.upper()}_UNREACHABLE;
    if (actuated_analysed(&actuated, after, load, gravity, w, actuated_result) != {name.upper()}_OK)
        return {name.upper()}_UNREACHABLE;
    update(search, actuated_result + {at["platform"]}, actuated_result + {at["twist"]}, w, next);
    for (k = 0; k < {search.errors}; ++k)
        if (!(fabs(next[{search.first_error} + k]) <= {literal(search.arrival_tolerance)})) return {name.upper()}_UNREACHABLE;
    return {name.upper()}_OK;
}}
"""


def _correction(name: str, parts: Programs) -> str:
    """Return the C code that follows the analysis of the target pose: the search and the joint limits."""
    return f"""    status = compensated(&pose, load, gravity, w, result, residual_error, actuators);
    state->corrections = pose.corrections;
    if (status != {name.upper()}_OK) return status;
    if (result[{parts.at["within"]}] == 0.0) status = {name.upper()}_LIMIT_EXCEEDED;
"""


# ---- derivatives ---------------------------------------------------------------------------------------------------------


def _differentiate(name: str, scalar: str, coordinates: Sequence[str], jacobian: CJacobian) -> str:
    lost = [
        f"    for (k = 0; k < {size(output) * size(value)}; ++k) jacobian->{field}[k] = ({scalar})NAN;"
        for output, value, field in jacobian.pairs
    ]
    blocks = [
        row for value in dict.fromkeys(pair[1] for pair in jacobian.pairs) for row in _by(value, scalar, coordinates, jacobian)
    ]
    rows = sum(size(output) for output in dict.fromkeys(pair[0] for pair in jacobian.pairs))
    return f"""
int {name}_differentiate(
    const {name}_input *input, {name}_state *state, {name}_output *output, {name}_jacobian *jacobian)
{{
    double w[WORK], d_x[NX * NT + 1], load[6], gravity[3], rate[{rows + 1}];
    double none[NX + 1] = {{0.0}}, d_load[6] = {{0.0}}, d_gravity[3] = {{0.0}};
    int i, k, status;
    if (!jacobian) return {name.upper()}_BAD_ARGUMENT;
{chr(10).join(lost)}
    status = {name}_evaluate(input, state, output);
    if (status != {name.upper()}_OK) return status;
    for (k = 0; k < 6; ++k) load[k] = (double)input->load[k];
    for (k = 0; k < 3; ++k) gravity[k] = (double)input->gravity[k];
    rates(state->x, state->c, w, d_x);
    if (d_x[NX * NT] == 0.0) return {name.upper()}_NOT_COVERED;
    (void)i; (void)none;
{chr(10).join(blocks)}
    return status;
}}
"""


def _by(value: Quantity, scalar: str, coordinates: Sequence[str], jacobian: CJacobian) -> Iterator[str]:
    """Yield lines of C for the derivatives with respect to one input."""
    columns, is_load = size(value), value.name in LOADS
    moved = "none" if is_load else f"d_x + {coordinates.index(value.name)} * NX"
    yield f"    for (k = 0; k < {columns}; ++k) {{"
    if is_load:
        yield f"        d_{value.name}[k] = 1.0;"
    yield f"        tangent(state->x, load, gravity, {moved}, d_load, d_gravity, w, rate);"
    for output, other, field in jacobian.pairs:
        if other is value:
            assignment = f"jacobian->{field}[i * {columns} + k] = ({scalar})rate[{jacobian.at[output.name]} + i];"
            yield f"        for (i = 0; i < {size(output)}; ++i) {assignment}"
    if is_load:
        yield f"        d_{value.name}[k] = 0.0;"
    yield "    }"
