"""Export of functions of a robot as C for controllers, with a test program that compares C with Python at reference poses."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from kinetostatics.arguments import check_choice, path_name
from kinetostatics.compensation import error_tolerance
from kinetostatics.engine.c_code import literal
from kinetostatics.engine.scalars import NotRecordedError
from kinetostatics.exceptions import ArgumentError
from kinetostatics.functions.c_names import c_comment, identifier
from kinetostatics.functions.c_programs import Exported, Programs
from kinetostatics.functions.c_source import c_array, valid
from kinetostatics.functions.c_texts import files
from kinetostatics.functions.inputs_outputs import Reference, Values
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.output_files import replacing
from kinetostatics.status import WITHOUT_NUMBERS, Status

#: Types of arguments and results.
SCALARS: Mapping[str, type[np.floating]] = {"double": np.float64, "float": np.float32}
#: Number of reference poses in the test program.
REFERENCES = 40


class Differentiated(Protocol):
    """Derivatives to be exported, see :class:`kinetostatics.functions.function.Jacobian`."""

    @property
    def of(self) -> tuple[str, ...]:
        """Names of the differentiated outputs."""

    @property
    def by(self) -> tuple[str, ...]:
        """Names of the inputs with respect to which the outputs are differentiated."""

    @property
    def __call__(self) -> Callable[..., Mapping[str, Mapping[str, Array]]]:
        """Function that returns the derivatives at given inputs."""


@dataclass(frozen=True)
class CExport:
    """Result of an export.

    Attributes:
        folder: folder of the files.
        files: names of the files.
        name: prefix of all names in C.
        operations: two numbers of operations: of one step of Newton's method for the pose, and of the analysis of the pose.
        work: size of the work array on the stack [bytes].
    """

    folder: Path
    files: tuple[str, ...]
    name: str
    operations: tuple[int, int]
    work: int


def export_c(
    function: Exported,
    folder: str | os.PathLike[str],
    scalar: str = "double",
    name: str | None = None,
    jacobian: Differentiated | None = None,
    near: Configuration | Values | None = None,
) -> CExport:
    """Write a function of a robot as C99, see :meth:`Function.export_c`."""
    check_choice("scalar", scalar, tuple(SCALARS))
    prefix = identifier(function.robot.name if name is None else name)
    start, parts = recorded(function, near, jacobian)
    references = _references(parts, jacobian, start, REFERENCES, SCALARS[scalar])
    texts = files(prefix, scalar, parts, _test_program(prefix, scalar, parts, references))
    where = write_files(folder, texts)
    return CExport(where, tuple(texts), prefix, (parts.line.newton.operations, parts.pose.operations), 8 * parts.work)


def write_files(folder: str | os.PathLike[str], texts: Mapping[str, str]) -> Path:
    """Write texts by their paths in a folder, all or none, and return the folder.

    Raises:
        ArgumentError: the files cannot be written.
    """
    where = Path(path_name("folder", folder))
    if where.exists() and not where.is_dir():
        raise ArgumentError(f"{where} is a file: the exported files need a folder")
    with contextlib.ExitStack() as all_or_none:
        for file, text in texts.items():
            try:
                (where / file).parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise ArgumentError(f"{where} cannot be written: {error.strerror or error}") from None
            all_or_none.enter_context(replacing(where / file)).write_text(text, encoding="utf-8")
    return where


def recorded(
    function: Exported, near: Configuration | Values | None, jacobian: Differentiated | None = None
) -> tuple[Configuration | None, Programs]:
    """Return the pose ``near`` and the programs of an export that starts there.

    Raises:
        ArgumentError: ``near`` is not one pose of the robot, or the robot or the orientation cannot be exported.
    """
    start = near.pose if isinstance(near, Values) else near
    of_this_robot = isinstance(start, Configuration) and start.robot is function.robot
    if start is not None and not (of_this_robot and start.shape == () and bool(start.reached[0])):
        raise ArgumentError("near= needs one closed pose of the robot for an export: create one with robot.assemble(…)")
    begin = function.robot.zero_poses if start is None else start.poses
    try:
        parts = Programs(function, begin, None if jacobian is None else (jacobian.of, jacobian.by))
    except NotRecordedError as error:
        raise ArgumentError(f"{function.robot.name!r} cannot be exported: {error}") from error
    return start, parts


def _references(
    parts: Programs, jacobian: Differentiated | None, near: Configuration | None, poses: int, scalar: type[np.floating]
) -> list[Reference]:
    """Return reference poses around the initial pose, with loads and Python's results.

    Two of three poses are near the initial pose; every third pose is up to six times as far from it. All numbers are
    representable in ``scalar``, so that C and Python compute the same poses.
    """
    rng = np.random.default_rng(0)
    function, robot, coordinates, start = parts.function, parts.function.robot, parts.coordinates, parts.at_start
    wide = np.where(np.arange(poses) % 3 == 2, 6.0, 1.0)
    steps = rng.uniform(-1, 1, (len(coordinates), poses)) * wide
    load = rng.uniform(-100, 100, (poses, 6)).astype(scalar).astype(float)
    gravity = (np.array([0.0, 0.0, -9.81]) + rng.uniform(-1, 1, (poses, 3))).astype(scalar).astype(float)
    for part in (0.15, 0.05, 0.015):  # of the robot's length, or rad; smaller until at least half of the poses are reached
        spans = {quantity.name: part * (robot.length if quantity.units[0] == "m" else 1.0) for quantity in coordinates}
        at = {name: start[name] + span * step for (name, span), step in zip(spans.items(), steps, strict=True)}
        at = {name: value.astype(scalar).astype(float) for name, value in at.items()}
        values = function(**at, load=load, gravity=gravity, near=near)
        if np.mean(np.isin(values["status"], WITHOUT_NUMBERS)) < 0.5:
            break
    references = []
    arrays = {quantity.name: values[quantity.name] for quantity in parts.outputs}
    if jacobian is not None:
        for output, columns in jacobian(**at, load=load, gravity=gravity, near=near).items():
            arrays |= {f"{output} by {name}": array for name, array in columns.items()}
    for k in range(poses):
        expected = {name: np.ravel(array[k]) for name, array in arrays.items()}
        status = int(values["status"][k])
        if status == Status.LIMIT_EXCEEDED and not function.compensates:  # C checks limits with compensation only
            status = int(Status.OK)
        references.append(({name: float(at[name][k]) for name in at}, load[k], gravity[k], expected, status))
    return references


# ---- test program --------------------------------------------------------------------------------------------------


def _test_program(name: str, scalar: str, parts: Programs, references: Sequence[Reference]) -> str:
    """Return a C program that compares results with Python's at the reference poses, and measures the time per call."""
    robot = parts.function.robot
    rows, names = [], [coordinate.name for coordinate in parts.coordinates]
    for at, load, gravity, expected, status in references:
        inputs = [at[coordinate] for coordinate in names]
        numbers = [value for values in expected.values() for value in values]
        rows.append(f"    {{{c_array([*inputs, *load, *gravity])}, {c_array(numbers)}, {status}}}")
    count, size = len(parts.coordinates) + 9, max(len(numbers), 1)
    steps = dict(zip(parts.function.names, 1e-3 * parts.line.longest_steps, strict=True))
    fill = [
        f"    input->{parts.c_names[coordinate]} = ({scalar})(row->input[{k}] + beside * {literal(float(steps[coordinate]))});"
        for k, coordinate in enumerate(names)
    ]
    first = len(parts.coordinates)
    checks, at_row = [] if parts.outputs else ["    (void)differ;"], 0
    for output in parts.outputs:
        n = int(np.prod(output.shape))
        absolute = literal(error_tolerance(robot.length) if output.name == "residual_error" else 0.0)
        checks.append(f'    failed |= differ("{output.name}", output.{output.name}, row->output + {at_row}, {n}, {absolute});')
        at_row += n
    jacobian, call = "", f"{name}_evaluate(&input, &state, &output)"
    if parts.jacobian is not None:
        jacobian, call = f"    {name}_jacobian jacobian;\n", f"{name}_differentiate(&input, &state, &output, &jacobian)"
        for output, by, field in parts.jacobian.pairs:
            n = int(np.prod((*output.shape, *by.shape)))
            largest = max((abs(value) for row in references for value in row[3][output.name] if np.isfinite(value)), default=0.0)
            absolute = literal(1e-12 * float(largest))  # for inputs without influence, Python's derivatives are rounding errors
            checks.append(f'    failed |= differ("{field}", jacobian.{field}, row->output + {at_row}, {n}, {absolute});')
            at_row += n
    tolerance = "1e-9" if scalar == "double" else "1e-5"
    return f"""/* {c_comment(robot.name)}: compares {name}.c with Python at the same poses. Written by kinetostatics. */
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
    if (!({valid(name, parts, "status")})) return 0;
{chr(10).join(checks)}
    return failed;
}}

{_measuring(name, parts, jacobian, call, len(rows))}
int main(void)
{{
    int failed = 0, k;
    for (k = 0; k < {len(rows)}; ++k) failed += check(&REFERENCES[k]);
    printf("%d of {len(rows)} poses differ\\n", failed);
    measure();
    return failed != 0;
}}
"""


def _measuring(name: str, parts: Programs, jacobian: str, call: str, count: int) -> str:
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
        if (!({valid(name, parts, "status")})) continue;
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
