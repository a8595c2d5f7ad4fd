"""The C file that computes, and the program that tests it; see :mod:`kinetostatics.functions.c_export`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetostatics.engine.c_code import CProgram, literal


def _array(values: Any) -> str:
    return "{" + ", ".join(literal(float(value)) for value in values) + "}" if len(values) else "{0.0}"


def source(name: str, scalar: str, facts: dict[str, Any]) -> str:
    """Return what computes."""
    parts = facts["parts"]
    programs: list[CProgram] = parts.programs
    nx, nt = parts.nx, parts.nt
    numbers = parts.frame_numbers
    coordinates = [f"    target[{k}] = (double)input->{facts['names'][place]};" for k, place in enumerate(facts["order"])]
    results, at = [], 0
    for item in parts.outputs:
        if item.name == "actuators":
            for k, row in enumerate(parts.drive_order):
                results.append(f"    output->actuators[{k}] = ({scalar})drive[{row}];")
        else:
            count = parts.rows[item.name]
            results.append(f"    for (k = 0; k < {count}; ++k) output->{item.name}[k] = ({scalar})result[{at} + k];")
            at += count
    lost = [
        f"    for (k = 0; k < {int(np.prod(item.shape))}; ++k) output->{item.name}[k] = ({scalar})NAN;" for item in parts.outputs
    ]
    side = (
        "    side(first->x, first->c, second->x, second->c, w, &sure);\n    return sure != 0.0;"
        if parts.side is not None
        else "    (void)first; (void)second; (void)w; (void)sure;\n    return 1; /* freedoms that move no platform are left */"
    )
    rows = sum(parts.rows.values())
    return f"""/* {facts["robot"]}: written by kinetostatics; see {name}.h. */
#include "{name}.h"

#include <math.h>
#include <string.h>

enum {{ NX = {nx}, NT = {nt}, WORK = {parts.work}, MOST_CORRECTIONS = {facts["corrections"]} }};
#ifndef {name.upper()}_MOST_STEPS
#define {name.upper()}_MOST_STEPS 200 /* of a line, those that were too long included */
#endif

static const double ZERO_X[{max(nx, 1)}] = {_array(parts.zero[0])};
static const double ZERO_C[3] = {_array(parts.zero[1])};
static const double ZERO_TARGET[{max(nt, 1)}] = {_array(parts.zero[2])};
static const double LONGEST[{max(nt, 1)}] = {_array(parts.strides)}; /* of a line in one go */

{chr(10).join(item.text for item in programs)}
static void impose(const double *target, double *x, double *c)
{{
    (void)target; (void)x; (void)c;
{chr(10).join(f"    {line}" for line in parts.impose)}
}}

/* Newton's method from a pose to a target beside it; returns whether it converged steadily. */
static int corrected({name}_state *pose, const double *target, int passing, double *w)
{{
    double state[NX + 8], given[NT + 1], next[NX + 9];
    int k;
    memcpy(given, target, NT * sizeof(double));
    given[NT] = passing ? 1.0 : 0.0;
    impose(target, pose->x, pose->c);
    memcpy(state, pose->x, NX * sizeof(double));
    memcpy(state + NX, pose->c, 3 * sizeof(double));
    state[NX + 3] = (double)INFINITY;
    state[NX + 4] = {literal(facts["shrinking"])};
    state[NX + 5] = 1.0;
    state[NX + 6] = 0.0;
    state[NX + 7] = 1.0;
    for (k = 0; k < MOST_CORRECTIONS && state[NX + 5] != 0.0; ++k) {{
        newton(state, given, w, next);
        memcpy(state, next, sizeof state);
    }}
    memcpy(pose->x, state, NX * sizeof(double));
    memcpy(pose->c, state + NX, 3 * sizeof(double));
    return state[NX + 6] != 0.0 && state[NX + 7] != 0.0;
}}

/* Whether there is surely no singular pose between two poses. */
static int on_one_side(const {name}_state *first, const {name}_state *second, double *w)
{{
    double sure = 0.0;
{side}
}}

/* Follow the straight line of coordinates; returns whether the end was reached. */
static int followed({name}_state *pose, const double *target, double *w)
{{
    double gone = 0.0, far = 0.0, longest, stride, goal[NT + 1];
    {name}_state moved;
    const {name}_state start = *pose;
    int steady = 1, k, steps;
    for (k = 0; k < NT; ++k) {{
        const double part = fabs(target[k] - start.target[k]) / LONGEST[k];
        if (part > far) far = part;
    }}
    longest = far > 1.0 ? 1.0 / far : 1.0;
    stride = longest;
    for (steps = 0; steps < {name.upper()}_MOST_STEPS; ++steps) {{
        const double trial = gone + stride < 1.0 ? gone + stride : 1.0;
        int good;
        for (k = 0; k < NT; ++k) goal[k] = start.target[k] + trial * (target[k] - start.target[k]);
        if (trial >= 1.0) memcpy(goal, target, NT * sizeof(double));
        moved = *pose;
        good = corrected(&moved, goal, trial < 1.0, w) && on_one_side(pose, &moved, w);
        if (good) {{
            *pose = moved;
            memcpy(pose->target, goal, NT * sizeof(double));
            gone = trial;
            if (gone >= 1.0) return 1;
            if (steady) stride = 2.0 * stride < longest ? 2.0 * stride : longest;
        }} else {{
            stride /= 2.0;
            if (stride <= 1e-3 * longest) return 0;
        }}
        steady = good;
    }}
    return 0;
}}

static void lost({name}_output *output)
{{
    int k;
{chr(10).join(lost)}
    output->residual = ({scalar})NAN;
}}

void {name}_start({name}_state *state)
{{
    memcpy(state->x, ZERO_X, sizeof state->x);
    memcpy(state->c, ZERO_C, sizeof state->c);
    memcpy(state->target, ZERO_TARGET, sizeof state->target);
}}

int {name}_evaluate(const {name}_input *input, {name}_state *state, {name}_output *output)
{{
    double w[WORK], target[NT + 1], load[6], gravity[3], frames_and_residual[{numbers + parts.closures + 1}];
    double result[{rows + 2}], drive[{max(len(parts.drive_order), 1)}], worst = 0.0;
    {name}_state pose;
    int k;
    if (!input || !state || !output) return {name.upper()}_BAD_ARGUMENT;
    lost(output);
{chr(10).join(coordinates)}
    for (k = 0; k < 6; ++k) load[k] = (double)input->load[k];
    for (k = 0; k < 3; ++k) gravity[k] = (double)input->gravity[k];
    for (k = 0; k < NT; ++k) if (!isfinite(target[k])) return {name.upper()}_BAD_ARGUMENT;
    for (k = 0; k < 6; ++k) if (!isfinite(load[k])) return {name.upper()}_BAD_ARGUMENT;
    for (k = 0; k < 3; ++k) if (!isfinite(gravity[k])) return {name.upper()}_BAD_ARGUMENT;
    pose = *state;
    if (!followed(&pose, target, w)) return {name.upper()}_UNREACHABLE;
    *state = pose;
    frames(pose.x, w, frames_and_residual);
    for (k = 0; k < {parts.closures}; ++k) {{
        const double open = fabs(frames_and_residual[{numbers} + k]);
        if (open > worst) worst = open;
    }}
    if (frames_and_residual[{numbers + parts.closures}] == 0.0) return {name.upper()}_NOT_COVERED;
    drives(pose.x, w, drive);
    (void)drive;
    statics(frames_and_residual, load, gravity, w, result);
    if (result[{rows + 1}] == 0.0) return {name.upper()}_NOT_COVERED;
    if (result[{rows}] != 0.0) return {name.upper()}_SINGULAR;
{chr(10).join(results)}
    output->residual = ({scalar})worst;
    return {name.upper()}_OK;
}}
"""


def test(name: str, scalar: str, facts: dict[str, Any], references: Sequence[Any]) -> str:
    """Return the program that compares with reference poses."""
    outputs = facts["parts"].outputs
    rows = []
    for at, load, gravity, expected, status in references:
        inputs = [at[item.name] for item in facts["coordinates"]]
        wanted = [value for item in outputs for value in expected[item.name]]
        rows.append(f"    {{{_array([*inputs, *load, *gravity])}, {_array(wanted)}, {0 if status == 1 else status}}}")
    count, size = len(facts["coordinates"]) + 9, sum(int(np.prod(item.shape)) for item in outputs)
    fill = [f"    input.{c_name} = ({scalar})row->input[{k}];" for k, c_name in enumerate(facts["names"])]
    first = len(facts["coordinates"])
    checks, at_row = [], 0
    for item in outputs:
        n = int(np.prod(item.shape))
        checks.append(f'    failed |= differ("{item.name}", output.{item.name}, row->output + {at_row}, {n});')
        at_row += n
    tolerance = "1e-9" if scalar == "double" else "1e-5"
    return f"""/* {facts["robot"]}: compares {name}.c with what Python says of the same poses. Written by kinetostatics. */
#include "{name}.h"

#include <math.h>
#include <stdio.h>

struct reference {{
    double input[{count}], output[{size}];
    int status;
}};

static const struct reference REFERENCES[{len(rows)}] = {{
{("," + chr(10)).join(rows)}
}};

/* Whether results differ from references by more than the tolerance, beside the largest of them. */
static int differ(const char *what, const {scalar} *found, const double *wanted, int n)
{{
    double largest = 1e-30, worst = 0.0;
    int k;
    for (k = 0; k < n; ++k) if (fabs(wanted[k]) > largest) largest = fabs(wanted[k]);
    for (k = 0; k < n; ++k) {{
        const double error = fabs((double)found[k] - wanted[k]);
        if (!(error <= worst)) worst = error;
    }}
    if (worst <= {tolerance} * largest) return 0;
    printf("%s differs by %g of %g\\n", what, worst, largest);
    return 1;
}}

static int check(const struct reference *row)
{{
    {name}_state state;
    {name}_input input;
    {name}_output output;
    int status, failed = 0, k;
{chr(10).join(fill)}
    for (k = 0; k < 6; ++k) input.load[k] = ({scalar})row->input[{first} + k];
    for (k = 0; k < 3; ++k) input.gravity[k] = ({scalar})row->input[{first + 6} + k];
    {name}_start(&state);
    status = {name}_evaluate(&input, &state, &output);
    if (status != row->status) {{
        printf("status %d instead of %d\\n", status, row->status);
        return 1;
    }}
    if (status != {name.upper()}_OK) return 0;
{chr(10).join(checks)}
    return failed;
}}

int main(void)
{{
    int failed = 0, k;
    for (k = 0; k < {len(rows)}; ++k) failed += check(&REFERENCES[k]);
    printf("%d of {len(rows)} poses differ\\n", failed);
    return failed != 0;
}}
"""
