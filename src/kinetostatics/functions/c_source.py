"""The C file that computes; see :mod:`kinetostatics.functions.c_export`."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from kinetostatics.engine.c_code import CProgram, literal
from kinetostatics.functions import c_jacobian
from kinetostatics.functions.values import Facts
from kinetostatics.math.arrays import Array


def c_array(values: Sequence[float] | Array) -> str:
    """Return an array as C spells it; there is none without entries."""
    return "{" + ", ".join(literal(float(value)) for value in values) + "}" if len(values) else "{0.0}"


def source(name: str, scalar: str, facts: Facts) -> str:
    """Return what computes."""
    parts = facts["parts"]
    programs: list[CProgram] = parts.programs
    nx, nt = parts.nx, parts.nt
    numbers = parts.frame_numbers
    coordinates = [f"    target[{k}] = (double)input->{facts['names'][place]};" for k, place in enumerate(facts["order"])]
    results, at = [], 0
    for item in parts.outputs:
        if item.name == "actuators":
            for k, row in enumerate(parts.actuator_order):
                results.append(f"    output->actuators[{k}] = ({scalar})actuator[{row}];")
        elif item.name == "remaining":
            results.append(f"    for (k = 0; k < 6; ++k) output->remaining[k] = ({scalar})remaining[k];")
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
    place = f"double frame[{numbers + parts.closures + 1}], result[{rows + 2}]"
    actuators = max(len(parts.actuator_order), 1)
    searched = parts.search is not None
    more = f"    double wanted[{actuators}], whole[{actuators + 1}], remaining[6], inside[2];\n" if searched else ""
    return f"""/* {facts["robot"]}: written by kinetostatics; see {name}.h. */
#include "{name}.h"

#include <math.h>
#include <string.h>

enum {{ NX = {nx}, NT = {nt}, WORK = {parts.work}, MOST_CORRECTIONS = {facts["corrections"]} }};
#ifndef {name.upper()}_MOST_STEPS
#define {name.upper()}_MOST_STEPS 200 /* of a line, those that were too long included */
#endif

static const double START_X[{max(nx, 1)}] = {c_array(parts.start[0])};
static const double START_C[3] = {c_array(parts.start[1])};
static const double START_TARGET[{max(nt, 1)}] = {c_array(parts.start[2])};
static const double LONGEST[{max(nt, 1)}] = {c_array(parts.strides)}; /* of a line in one go */

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
        ++pose->corrections;
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
    {name}_state start = *pose;
    int steady = 1, k, steps;
{_line_start(facts)}    for (k = 0; k < NT; ++k) {{
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

/* What the statics say of a closed pose: its frames and by how much its loops are open, the results, and a status. */
static int analysed(
    {name}_state *pose, const double *load, const double *gravity, double *w, double *frame, double *worst, double *result)
{{
    int k, again;
    for (again = 0; again < 2; ++again) {{
        frames(pose->x, w, frame);
        *worst = 0.0;
        for (k = 0; k < {parts.closures}; ++k) {{
            const double open = fabs(frame[{numbers} + k]);
            if (open > *worst) *worst = open;
        }}
        /* the last correction of some poses was not quite as small as expected */
        if (again || !(*worst > {literal(facts["rough"])})) break;
        (void)corrected(pose, pose->target, 0, w);
    }}
    if (frame[{numbers + parts.closures}] == 0.0) return {name.upper()}_NOT_COVERED;
    statics(frame, load, gravity, w, result);
    if (result[{rows + 1}] == 0.0) return {name.upper()}_NOT_COVERED;
    return result[{rows}] != 0.0 ? {name.upper()}_SINGULAR : {name.upper()}_OK;
}}
{_compensated(name, facts) if searched else ""}
static void lost({name}_output *output)
{{
    int k;
{chr(10).join(lost)}
    output->residual = ({scalar})NAN;
}}

void {name}_start({name}_state *state)
{{
    memcpy(state->x, START_X, sizeof state->x);
    memcpy(state->c, START_C, sizeof state->c);
    memcpy(state->target, START_TARGET, sizeof state->target);
    state->moved = {0.0 if facts["from_zero"] else 1.0};
    state->corrections = 0;
}}

int {name}_evaluate(const {name}_input *input, {name}_state *state, {name}_output *output)
{{
    double w[WORK], target[NT + 1], load[6], gravity[3], worst, actuator[{actuators}];
    {place};
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
    if (!followed(&pose, target, w)) return {name.upper()}_UNREACHABLE;
    status = analysed(&pose, load, gravity, w, frame, &worst, result);
    *state = pose;
    if (status != {name.upper()}_OK) return status;
{_correction(name) if searched else "    actuators(pose.x, w, actuator);" + chr(10) + "    (void)actuator;"}
{chr(10).join(results)}
    output->residual = ({scalar})worst;
    return status;
}}
{c_jacobian.source(name, scalar, facts) if parts.jacobian is not None else ""}"""


def _line_start(facts: Facts) -> str:
    """Return what makes the coordinates where a line starts those that are nearest to its end, where several mean the same."""
    if facts["parts"].line is None:
        return ""
    unsure = " || ".join(f"!(fabs(pose->c[{k}]) < {facts['unique_below']})" for k in range(3))
    return f"""    if ({unsure}) {{
        double begin[NT + 4];
        line(start.target, pose->c, target, &start.moved, w, begin);
        if (begin[NT + 3] != 0.0) {{
            memcpy(start.target, begin, NT * sizeof(double));
            memcpy(pose->c, begin + NT, 3 * sizeof(double));
        }}
    }}
"""


def _compensated(name: str, facts: Facts) -> str:
    """Return the function that searches where the unloaded robot is commanded."""
    parts = facts["parts"]
    search, size = parts.search, parts.search.numbers
    at = sum(parts.rows[item] for item in itertools.takewhile(lambda item: item != "twist", parts.rows))
    return f"""
/* Go on until the loaded platform stands where it was asked to: Broyden's method, from the wanted pose and what is known there.
 * Each of its steps follows a line. */
static int compensated(
    {name}_state *pose, const double *load, const double *gravity, double *w, double *frame, double *worst, double *result,
    double *remaining)
{{
    double asked[13], stands[13], search[{size + 1}], next[{size + 1}], left[7];
    const double *const twist = result + {at};
    int k;
    platform(frame, w, asked);
    begin(asked, twist, w, search);
    if (search[{size}] == 0.0) return {name.upper()}_NOT_COVERED;
    for (k = 0; k < {facts["searches"]} && search[{search.going}] != 0.0; ++k) {{
        int status;
        if (!followed(pose, search, w)) return {name.upper()}_UNREACHABLE;
        status = analysed(pose, load, gravity, w, frame, worst, result);
        if (status != {name.upper()}_OK) return status == {name.upper()}_SINGULAR ? {name.upper()}_UNREACHABLE : status;
        platform(frame, w, stands);
        learn(search, stands, twist, w, next);
        if (next[{size}] == 0.0) return {name.upper()}_NOT_COVERED;
        memcpy(search, next, sizeof search);
    }}
    if (!(search[{search.size}] <= {literal(search.enough)})) return {name.upper()}_UNREACHABLE;
    platform(frame, w, stands);
    remains(asked, stands, twist, w, left);
    memcpy(remaining, left, 6 * sizeof(double));
    return left[6] == 0.0 ? {name.upper()}_NOT_COVERED : {name.upper()}_OK;
}}
"""


def _correction(name: str) -> str:
    """Return what is done behind the analysis of the wanted pose."""
    return f"""    actuators(pose.x, w, wanted);
    status = compensated(&pose, load, gravity, w, frame, &worst, result, remaining);
    state->corrections = pose.corrections;
    if (status != {name.upper()}_OK) return status;
    actuators(pose.x, w, actuator);
    correct(wanted, actuator, w, whole);
    memcpy(actuator, whole, sizeof actuator);
    limits(pose.x, w, inside);
    if (inside[1] == 0.0) return {name.upper()}_NOT_COVERED;
    if (inside[0] == 0.0) status = {name.upper()}_LIMIT_EXCEEDED;"""


def valid(name: str, facts: Facts, status: str) -> str:
    """Return C that tells whether outputs are valid."""
    found = f"{status} == {name.upper()}_OK"
    return f"{found} || {status} == {name.upper()}_LIMIT_EXCEEDED" if facts["compensates"] else found
