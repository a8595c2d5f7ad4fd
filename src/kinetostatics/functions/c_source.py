"""The C file that computes; see :mod:`kinetostatics.functions.c_export`."""

from __future__ import annotations

import itertools

import numpy as np

from kinetostatics.engine.c_code import CProgram, literal
from kinetostatics.functions import c_jacobian, c_lines
from kinetostatics.functions.c_lines import c_array
from kinetostatics.functions.values import Facts


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
        elif item.name == "residual_error":
            results.append(f"    for (k = 0; k < 6; ++k) output->residual_error[k] = ({scalar})residual_error[k];")
        else:
            count = parts.rows[item.name]
            results.append(f"    for (k = 0; k < {count}; ++k) output->{item.name}[k] = ({scalar})result[{at} + k];")
            at += count
    lost = [
        f"    for (k = 0; k < {int(np.prod(item.shape))}; ++k) output->{item.name}[k] = ({scalar})NAN;" for item in parts.outputs
    ]
    rows = sum(parts.rows.values())
    place = f"double frame[{numbers + parts.closures + 1}], result[{rows + 3}]"
    actuators = max(len(parts.actuator_order), 1)
    searched = parts.search is not None
    lines = [parts.line, *([] if parts.drives is None else [parts.drives])]
    more = "    double residual_error[6], inside[2];\n" if searched else ""
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

{chr(10).join(item.text for item in programs)}
{chr(10).join(c_lines.source(name, facts, line) for line in lines)}
/* What the statics say of frames: the results, and a status. */
static int analysed(const double *frame, const double *load, const double *gravity, double *w, double *result)
{{
    if (frame[{numbers + parts.closures}] == 0.0) return {name.upper()}_NOT_COVERED;
    statics(frame, load, gravity, w, result);
    if (result[{rows + 1}] == 0.0) return {name.upper()}_NOT_COVERED;
    if (result[{rows}] != 0.0) return {name.upper()}_SINGULAR;
    return result[{rows + 2}] == 0.0 ? {name.upper()}_NOT_COVERED : {name.upper()}_OK;
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
    if (!followed(&pose, pose.target, target, w)) return {name.upper()}_UNREACHABLE;
    closed(&pose, pose.target, w, frame, &worst);
    status = analysed(frame, load, gravity, w, result);
    *state = pose;
    if (status != {name.upper()}_OK) return status;
{_correction(name) if searched else "    actuators(pose.x, w, actuator);" + chr(10) + "    (void)actuator;"}
{chr(10).join(results)}
    output->residual = ({scalar})worst;
    return status;
}}
{c_jacobian.source(name, scalar, facts) if parts.jacobian is not None else ""}"""


def _compensated(name: str, facts: Facts) -> str:
    """Return the function that searches where the unloaded robot is commanded."""
    parts = facts["parts"]
    search, size, actuators = parts.search, parts.search.numbers, max(len(parts.actuator_order), 1)
    frame, rows = parts.frame_numbers + parts.closures + 1, sum(parts.rows.values()) + 3
    at = sum(parts.rows[item] for item in itertools.takewhile(lambda item: item != "twist", parts.rows))
    return f"""
/* Go on until the loaded platform stands where it was asked to: Broyden's method, from the wanted pose and what is known there.
 * Each of its steps follows a line. Then the actuators are moved where they were found, straight from the wanted pose: beyond a
 * singular pose they would hold the platform elsewhere. */
static int compensated(
    {name}_state *pose, const double *load, const double *gravity, double *w, double *frame, double *worst, double *result,
    double *residual_error, double *actuator)
{{
    double asked[13], stands[13], search[{size + 1}], next[{size + 1}], left[7], wanted[{actuators}], whole[{actuators + 1}];
    double open, driven_frame[{frame}], driven_result[{rows}];
    const double *const twist = result + {at};
    {name}_state driven = *pose;
    int k;
    actuators(pose->x, w, wanted);
    platform(frame, w, asked);
    begin(asked, twist, w, search);
    if (search[{size}] == 0.0) return {name.upper()}_NOT_COVERED;
    for (k = 0; k < {facts["searches"]} && search[{search.going}] != 0.0; ++k) {{
        int status;
        if (!followed(pose, pose->target, search, w)) return {name.upper()}_UNREACHABLE;
        closed(pose, pose->target, w, frame, worst);
        status = analysed(frame, load, gravity, w, result);
        if (status != {name.upper()}_OK) return status == {name.upper()}_SINGULAR ? {name.upper()}_UNREACHABLE : status;
        platform(frame, w, stands);
        learn(search, stands, twist, w, next);
        if (next[{size}] == 0.0) return {name.upper()}_NOT_COVERED;
        memcpy(search, next, sizeof search);
    }}
    if (!(search[{search.size}] <= {literal(search.enough)})) return {name.upper()}_UNREACHABLE;
    platform(frame, w, stands);
    remains(asked, stands, twist, w, left);
    memcpy(residual_error, left, 6 * sizeof(double));
    if (left[6] == 0.0) return {name.upper()}_NOT_COVERED;
    actuators(pose->x, w, actuator);
    correct(wanted, actuator, w, whole);
    memcpy(actuator, whole, sizeof wanted);
    driven.corrections = pose->corrections;
    k = driven_followed(&driven, wanted, actuator, w);
    pose->corrections = driven.corrections;
    if (!k) return {name.upper()}_UNREACHABLE;
    driven_closed(&driven, actuator, w, driven_frame, &open);
    if (analysed(driven_frame, load, gravity, w, driven_result) != {name.upper()}_OK) return {name.upper()}_UNREACHABLE;
    platform(driven_frame, w, stands);
    learn(search, stands, driven_result + {at}, w, next);
    for (k = 0; k < {search.count}; ++k)
        if (!(fabs(next[{search.error} + k]) <= {literal(search.led)})) return {name.upper()}_UNREACHABLE;
    return {name.upper()}_OK;
}}
"""


def _correction(name: str) -> str:
    """Return what is done behind the analysis of the wanted pose."""
    return f"""    status = compensated(&pose, load, gravity, w, frame, &worst, result, residual_error, actuator);
    state->corrections = pose.corrections;
    if (status != {name.upper()}_OK) return status;
    limits(pose.x, w, inside);
    if (inside[1] == 0.0) return {name.upper()}_NOT_COVERED;
    if (inside[0] == 0.0) status = {name.upper()}_LIMIT_EXCEEDED;"""


def valid(name: str, facts: Facts, status: str) -> str:
    """Return C that tells whether outputs are valid."""
    found = f"{status} == {name.upper()}_OK"
    return f"{found} || {status} == {name.upper()}_LIMIT_EXCEEDED" if facts["compensates"] else found
