"""Test program of the exported C: comparison with Python's results at some poses, and time per call."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetostatics.engine.c_code import literal
from kinetostatics.functions.c_source import c_array, valid
from kinetostatics.functions.inputs_outputs import Facts, Reference


def test(name: str, scalar: str, facts: Facts, references: Sequence[Reference]) -> str:
    """Return the program that compares with reference poses."""
    outputs = facts["parts"].outputs
    rows = []
    for at, load, gravity, expected, status in references:
        inputs = [at[item.name] for item in facts["coordinates"]]
        numbers = [value for values in expected.values() for value in values]
        rows.append(f"    {{{c_array([*inputs, *load, *gravity])}, {c_array(numbers)}, {status}}}")
    count, size = len(facts["coordinates"]) + 9, len(numbers)
    steps = dict(zip(facts["controlled"], 1e-3 * facts["parts"].line.strides, strict=True))
    fill = [
        f"    input->{c_name} = ({scalar})(row->input[{k}] + beside * {literal(float(steps[item.name]))});"
        for k, (c_name, item) in enumerate(zip(facts["names"], facts["coordinates"], strict=True))
    ]
    first = len(facts["coordinates"])
    checks, at_row = [], 0
    for item in outputs:
        n = int(np.prod(item.shape))
        absolute = literal(facts["absolute"].get(item.name, 0.0))
        checks.append(f'    failed |= differ("{item.name}", output.{item.name}, row->output + {at_row}, {n}, {absolute});')
        at_row += n
    jacobian, call = "", f"{name}_evaluate(&input, &state, &output)"
    if facts["parts"].jacobian is not None:
        jacobian, call = f"    {name}_jacobian jacobian;\n", f"{name}_differentiate(&input, &state, &output, &jacobian)"
        for one, other, field in facts["parts"].jacobian.pairs:
            n = int(np.prod((*one.shape, *other.shape)))
            largest = max((abs(value) for row in references for value in row[3][one.name] if np.isfinite(value)), default=0.0)
            absolute = literal(1e-12 * float(largest))  # for inputs without influence, Python's derivatives are rounding errors
            checks.append(f'    failed |= differ("{field}", jacobian.{field}, row->output + {at_row}, {n}, {absolute});')
            at_row += n
    tolerance = "1e-9" if scalar == "double" else "1e-5"
    return f"""/* {facts["robot"]}: compares {name}.c with results of Python at the same poses. Written by kinetostatics. */
#include "{name}.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

struct reference {{
    double input[{count}], output[{size}];
    int status;
}};

static const struct reference REFERENCES[{len(rows)}] = {{
{("," + chr(10)).join(rows)}
}};

/* Whether results differ from references by more than the tolerance times the largest of them, and an absolute tolerance. */
static int differ(const char *what, const {scalar} *found, const double *expected, int n, double absolute)
{{
    double largest = 1e-30, worst = 0.0;
    int k;
    for (k = 0; k < n; ++k) if (fabs(expected[k]) > largest) largest = fabs(expected[k]);
    for (k = 0; k < n; ++k) {{
        const double error = fabs((double)found[k] - expected[k]);
        if (!(error <= worst)) worst = error;
    }}
    if (worst <= {tolerance} * largest + absolute) return 0;
    printf("%s differs by %g of %g\\n", what, worst, largest);
    return 1;
}}

/* The input of a reference pose, with coordinates changed by "beside" thousandths of the longest step of a line. */
static void fill(const struct reference *row, double beside, {name}_input *input)
{{
    int k;
{chr(10).join(fill)}
    for (k = 0; k < 6; ++k) input->load[k] = ({scalar})row->input[{first} + k];
    for (k = 0; k < 3; ++k) input->gravity[k] = ({scalar})row->input[{first + 6} + k];
}}

static int check(const struct reference *row)
{{
    {name}_state state;
    {name}_input input;
    {name}_output output;
{jacobian}    int status, failed = 0;
    fill(row, 0.0, &input);
    {name}_start(&state);
    status = {call};
    if (status != row->status) {{
        printf("status %d instead of %d\\n", status, row->status);
        return 1;
    }}
    if (!({valid(name, facts, "status")})) return 0;
{chr(10).join(checks)}
    return failed;
}}

{_measuring(name, facts, jacobian, call, len(rows))}
int main(void)
{{
    int failed = 0, k;
    for (k = 0; k < {len(rows)}; ++k) failed += check(&REFERENCES[k]);
    printf("%d of {len(rows)} poses differ\\n", failed);
    measure();
    return failed != 0;
}}
"""


def _measuring(name: str, facts: Facts, jacobian: str, call: str, count: int) -> str:
    """Return the code that measures the time per call."""
    return f"""/* Counter of the processor, if available: cycles (DWT->CYCCNT) of a Cortex-M, time stamps of an x86. */
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define TICKS "time stamps"
static unsigned ticks(void) {{ return (unsigned)__builtin_ia32_rdtsc(); }}
#elif defined(__ARM_ARCH_7M__) || defined(__ARM_ARCH_7EM__) || defined(__ARM_ARCH_8M_MAIN__)
#define TICKS "cycles"
static unsigned ticks(void)
{{
    *(volatile unsigned *)0xE000EDFCu |= 1u << 24; /* DEMCR.TRCENA */
    *(volatile unsigned *)0xE0001FB0u = 0xC5ACCE55u; /* DWT_LAR: unlock */
    *(volatile unsigned *)0xE0001000u |= 1u; /* DWT_CTRL.CYCCNTENA */
    return *(volatile unsigned *)0xE0001004u; /* DWT_CYCCNT */
}}
#else
static unsigned ticks(void) {{ return 0; }}
#endif

/* Time of calls with small steps to and fro about reference poses, as in a controller. */
static void measure(void)
{{
    {name}_state state;
    {name}_input input;
    {name}_output output;
{jacobian}    double seconds = 0.0, corrections = 0.0, least = 0.0;
    int calls = 0, k, n;
    for (k = 0; k < {count} && calls < 500; ++k) {{
        const int status = REFERENCES[k].status;
        clock_t begin;
        unsigned first, before;
        double passed;
        if (!({valid(name, facts, "status")})) continue;
        {name}_start(&state);
        fill(&REFERENCES[k], 0.0, &input);
        (void){call};
        before = state.corrections;
        begin = clock();
        first = ticks();
        for (n = 0; n < 100; ++n) {{
            fill(&REFERENCES[k], n % 2 ? 0.0 : 1.0, &input);
            (void){call};
        }}
        passed = (double)(ticks() - first) / 100.0;
        seconds += (double)(clock() - begin) / (double)CLOCKS_PER_SEC;
        corrections += (double)(state.corrections - before);
        least = calls == 0 || passed < least ? passed : least;
        calls += 100;
    }}
    if (calls == 0) return;
    printf("%.3g corrections of the loops per call, average of %d calls\\n", corrections / calls, calls);
    if (seconds > 0.0) printf("%.3g microseconds per call, average of the same calls\\n", 1e6 * seconds / calls);
#ifdef TICKS
    printf("%.0f " TICKS " per call, at the fastest pose\\n", least);
#endif
    (void)least;
}}
"""
