"""The program that compares the exported C with what Python says of some poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinetostatics.engine.c_code import literal
from kinetostatics.functions.c_source import c_array, valid


def test(name: str, scalar: str, facts: dict[str, Any], references: Sequence[Any]) -> str:
    """Return the program that compares with reference poses."""
    outputs = facts["parts"].outputs
    rows = []
    for at, load, gravity, expected, status in references:
        inputs = [at[item.name] for item in facts["coordinates"]]
        wanted = [value for values in expected.values() for value in values]
        rows.append(f"    {{{c_array([*inputs, *load, *gravity])}, {c_array(wanted)}, {status}}}")
    count, size = len(facts["coordinates"]) + 9, len(wanted)
    fill = [f"    input.{c_name} = ({scalar})row->input[{k}];" for k, c_name in enumerate(facts["names"])]
    first = len(facts["coordinates"])
    checks, at_row = [], 0
    for item in outputs:
        n = int(np.prod(item.shape))
        sharp = literal(facts["sharp"].get(item.name, 0.0))
        checks.append(f'    failed |= differ("{item.name}", output.{item.name}, row->output + {at_row}, {n}, {sharp});')
        at_row += n
    jacobian, call = "", f"{name}_evaluate(&input, &state, &output)"
    if facts["parts"].jacobian is not None:
        jacobian, call = f"    {name}_jacobian jacobian;\n", f"{name}_differentiate(&input, &state, &output, &jacobian)"
        for one, other, field in facts["parts"].jacobian.pairs:
            n = int(np.prod((*one.shape, *other.shape)))
            largest = max((abs(value) for row in references for value in row[3][one.name] if np.isfinite(value)), default=0.0)
            sharp = literal(1e-12 * float(largest))  # of what does not depend on an input, Python tells rounding
            checks.append(f'    failed |= differ("{field}", jacobian.{field}, row->output + {at_row}, {n}, {sharp});')
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

/* Whether results differ from references by more than the tolerance, beside the largest of them, and what is sharp in itself. */
static int differ(const char *what, const {scalar} *found, const double *wanted, int n, double sharp)
{{
    double largest = 1e-30, worst = 0.0;
    int k;
    for (k = 0; k < n; ++k) if (fabs(wanted[k]) > largest) largest = fabs(wanted[k]);
    for (k = 0; k < n; ++k) {{
        const double error = fabs((double)found[k] - wanted[k]);
        if (!(error <= worst)) worst = error;
    }}
    if (worst <= {tolerance} * largest + sharp) return 0;
    printf("%s differs by %g of %g\\n", what, worst, largest);
    return 1;
}}

static int check(const struct reference *row)
{{
    {name}_state state;
    {name}_input input;
    {name}_output output;
{jacobian}    int status, failed = 0, k;
{chr(10).join(fill)}
    for (k = 0; k < 6; ++k) input.load[k] = ({scalar})row->input[{first} + k];
    for (k = 0; k < 3; ++k) input.gravity[k] = ({scalar})row->input[{first + 6} + k];
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

int main(void)
{{
    int failed = 0, k;
    for (k = 0; k < {len(rows)}; ++k) failed += check(&REFERENCES[k]);
    printf("%d of {len(rows)} poses differ\\n", failed);
    return failed != 0;
}}
"""
