"""Texts of the exported files: header, C++ wrapper, build file and README."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from kinetostatics.compensation import MOST
from kinetostatics.functions.c_names import c_comment, markdown
from kinetostatics.functions.c_programs import Programs
from kinetostatics.functions.c_source import size, source, valid
from kinetostatics.functions.inputs_outputs import Quantity
from kinetostatics.kinematics.solver import MOST_CORRECTIONS

#: Statuses in C: name, number (as in Python) and meaning.
STATUSES = (
    ("OK", 0, "all numbers are valid; joint limits are not checked"),
    ("UNREACHABLE", 2, "the loops do not close at the pose or on the straight line to it; outputs are NaN"),
    ("SINGULAR", 3, "the pose is singular: a part is not constrained; outputs are NaN, the state is at the pose"),
    ("NOT_COVERED", 6, "the pose or a limb is singular or nearly so, and needs Python; outputs are NaN"),
    ("BAD_ARGUMENT", 7, "an argument is not finite, or a pointer is null"),
)
#: Statuses of functions with compensation.
STATUSES_OF_COMPENSATION = (
    ("OK", 0, "all numbers are valid, all joints are within their limits"),
    ("LIMIT_EXCEEDED", 1, "all numbers are valid; a joint or actuator is beyond its limit (values are not clipped)"),
    ("UNREACHABLE", 2, "the loops do not close at the pose, or no reachable correction was found; outputs are NaN"),
    *STATUSES[2:],
)
#: Columns of the table of operations, with the operations counted in them; all others are in the last column.
_KINDS = {
    "additions": ("add", "subtract"),
    "multiplications": ("multiply",),
    "divisions": ("divide",),
    "square roots": ("square_root",),
    "sines, cosines": ("sine", "cosine"),
    "arc tangents": ("angle",),
    "signs, roundings": ("negative", "absolute", "whole"),
}


def files(name: str, scalar: str, parts: Programs, test: str) -> dict[str, str]:
    """Return the texts of all files by name; ``test`` is the text of the test program."""
    return {
        f"{name}.h": header(name, scalar, parts),
        f"{name}.c": source(name, scalar, parts),
        f"{name}.hpp": _wrapper(name, parts),
        f"{name}_test.c": test,
        "CMakeLists.txt": _cmake(name),
        "README.md": _readme(name, scalar, parts),
    }


def _statuses(parts: Programs) -> Sequence[tuple[str, int, str]]:
    return STATUSES_OF_COMPENSATION if parts.function.compensates else STATUSES


def _about(parts: Programs) -> str:
    if not parts.function.compensates:
        return "sag and forces of one pose"
    return "actuator coordinates and feedforward forces with which the loaded platform has its target pose"


def _words(quantity: Quantity, escaped: Callable[[str], str]) -> str:
    """Return meaning, order of components, which may be named after parts, and units of a quantity."""
    units = ", ".join(dict.fromkeys(quantity.units))
    rows, last = (tuple(map(escaped, labels)) for labels in ((), (), *quantity.axes.values())[-2:])
    parts = [quantity.meaning, f"in the order {', '.join(last)}" if last else ""]
    if rows:
        more = "" if rows == last else f", rows {', '.join(rows)}"
        parts.append(f"row by row, {quantity.shape[0]} x {quantity.shape[1]}{more}")
    return f"{'; '.join(part for part in parts if part)} [{units}]".replace("·", " ").replace("²", "2")


def header(name: str, scalar: str, parts: Programs) -> str:
    function, guard = parts.function, f"{name.upper()}_H"
    inputs = []
    for quantity in parts.coordinates:
        limits = parts.limits.get(quantity.name) if function.by_actuators else None
        range_ = f"valid from {limits[0]:.6g} to {limits[1]:.6g}" if limits else "the status is UNREACHABLE outside the workspace"
        zero = f"{parts.at_start[quantity.name]:.6g} at the {'zero' if parts.from_zero else 'start'} pose"
        words = f"{c_comment(quantity.name)}: {_words(quantity, c_comment)}; {zero}; {range_}"
        inputs.append(f"    {scalar} {parts.c_names[quantity.name]}; /* {words} */")
    outputs = [f"    {scalar} {output.name}[{size(output)}]; /* {_words(output, c_comment)} */" for output in parts.outputs]
    effort = ""
    if parts.efforts:
        effort = f"    {scalar} effort_exceeded; /* 1 if an actuator's force is beyond the effort in the file, else 0 */\n"
    statuses = ",\n".join(f"    {name.upper()}_{key} = {value} /* {words} */" for key, value, words in _statuses(parts))
    actuators = [f" *   {c_comment(actuator)}: {lower:.6g} to {upper:.6g}" for actuator, (lower, upper) in parts.limits.items()]
    checked = "checked by the status" if function.compensates else "not checked"
    ranges = "\n".join([f" * Ranges of the actuators' coordinates [m, rad], {checked}:", *actuators]) if actuators else " *"
    return f"""/* {c_comment(function.robot.name)}: {_about(parts)}.
 * Written by kinetostatics.
 *
 * SI units, world axes (those of the base), reference point o of the platform. Angles are in radians;
 * orientation: {function.orientation or "rotation_vector"}. Nothing is allocated, and all state is in the argument "state":
 * any number of threads may call, each with its own state.
{ranges}
 */
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif

/* Status of a call. */
enum {name}_status {{
{statuses}
}};

/* Present pose, at which the straight line of coordinates to the next pose starts. Do not change its fields. */
typedef struct {{
    double x[{max(len(parts.start[0]), 1)}];
    double c[3];
    double target[{max(len(parts.start[2]), 1)}];
    double moved;
    unsigned corrections; /* number of all corrections of the loops: the only field that may be read */
}} {name}_state;

typedef struct {{
{chr(10).join(inputs)}
    {scalar} load[6]; /* external force and moment on the platform about o, world axes [N, N m]; a payload of mass m, with its
                        centre c from o, adds m gravity and c x m gravity */
    {scalar} gravity[3]; /* world axes [m/s2]: (0, 0, -9.81) where z points up */
}} {name}_input;

typedef struct {{
{chr(10).join(outputs)}
{effort}    {scalar} residual; /* largest residual of the equations of the loops [m or rad] */
}} {name}_output;

/* Set the state to the robot's {"zero pose" if parts.from_zero else "start pose, given at the export"}. */
void {name}_start({name}_state *state);

{_evaluates(parts)}
int {name}_evaluate(const {name}_input *input, {name}_state *state, {name}_output *output);
{"" if parts.jacobian is None else _declared(name, scalar, parts)}
#ifdef __cplusplus
}}
#endif

#endif
"""


def _evaluates(parts: Programs) -> str:
    if not parts.function.compensates:
        return "/* Move to a pose and compute the outputs; returns the status. If it is UNREACHABLE, the state is unchanged. */"
    names = ", ".join(parts.function.names)
    return f"""/* Find the actuator coordinates at which the loaded platform has the given {names}, and compute
 * the outputs there; returns the status. The state moves to the target pose, or is unchanged if that is out of reach. */"""


def _declared(name: str, scalar: str, parts: Programs) -> str:
    assert parts.jacobian is not None
    fields = []
    for output, value, field in parts.jacobian.pairs:
        shape = " x ".join(str(n) for n in (*output.shape, *value.shape))
        fields.append(f"    {scalar} {field}[{size(output) * size(value)}]; /* {shape}, row by row */")
    return f"""
/* Derivatives of outputs with respect to inputs, with closed loops. */
typedef struct {{
{chr(10).join(fields)}
}} {name}_jacobian;

/* As {name}_evaluate, with derivatives; they are NaN if the status is not OK. */
int {name}_differentiate(
    const {name}_input *input, {name}_state *state, {name}_output *output, {name}_jacobian *jacobian);
"""


def _wrapper(name: str, parts: Programs) -> str:
    differentiate = f"""    int differentiate(const Input &input, Output &output, ::{name}_jacobian &jacobian)
    {{
        return ::{name}_differentiate(&input, &state_, &output, &jacobian);
    }}
"""
    return f"""// {c_comment(parts.function.robot.name)}: a C++ wrapper of {name}.h, written by kinetostatics.
#ifndef {name.upper()}_HPP
#define {name.upper()}_HPP

#include "{name}.h"

namespace {name} {{

using Input = ::{name}_input;
using Output = ::{name}_output;

// A robot with its present pose; each thread needs an object of its own.
class Robot {{
public:
    Robot() {{ reset(); }}
    void reset() {{ ::{name}_start(&state_); }}
    // Returns the status; see {name}_status.
    int evaluate(const Input &input, Output &output) {{ return ::{name}_evaluate(&input, &state_, &output); }}
{differentiate if parts.jacobian else ""}    static bool valid(int status) {{ return {valid(name, parts, "status")}; }}

private:
    ::{name}_state state_;
}};

}}  // namespace {name}

#endif
"""


def _cmake(name: str) -> str:
    return f"""# Written by kinetostatics.
cmake_minimum_required(VERSION 3.13)
project({name} C)

add_library({name} STATIC {name}.c)
target_include_directories({name} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
set_target_properties({name} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
find_library(MATH m)
if(MATH)
  target_link_libraries({name} PUBLIC ${{MATH}})
endif()

enable_testing()
add_executable({name}_test {name}_test.c)
target_link_libraries({name}_test {name})
add_test(NAME {name} COMMAND {name}_test)
"""


def _readme(name: str, scalar: str, parts: Programs) -> str:
    function = parts.function
    inputs = "\n".join(f"- `{parts.c_names[quantity.name]}`: {_words(quantity, markdown)}" for quantity in parts.coordinates)
    outputs = "\n".join(f"- `{quantity.name}[{size(quantity)}]`: {_words(quantity, markdown)}" for quantity in parts.outputs)
    statuses = "\n".join(f"| `{name.upper()}_{key}` | {value} | {words} |" for key, value, words in _statuses(parts))
    example = "\n".join(
        f"input.{parts.c_names[quantity.name]} = {parts.at_start[quantity.name]:.6g}; /* {quantity.units[0]} */"
        for quantity in parts.coordinates
    )
    where = " at the corrected pose" if function.compensates else ""
    # sines and cosines of given angles are not in the records
    count = sum(line.count("= cos(") + line.count("= sin(") for line in parts.line.impose)
    outside = f", nor are {count} sines and cosines of given angles in each step of a line" if count else ""
    floats = derivatives = ""
    if scalar == "float":
        floats = "Arguments and results are `float`; computations are in `double`, as `float` closes loops badly.\n\n"
    if parts.jacobian is not None:
        derivatives = f"""`{name}_differentiate` also computes exact derivatives with closed loops, row by row, with the output's
components first: {", ".join(f"`{field}`" for _, _, field in parts.jacobian.pairs)}.

"""
    return f"""# {markdown(function.robot.name)} for a controller

{_about(parts)[0].upper()}{_about(parts)[1:]}.
C99, written by `kinetostatics export`: no heap, no library but libm, bounded iterations, all state in an argument.
{name}.hpp wraps it for C++.

```c
#include "{name}.h"

{name}_state state;
{name}_input input = {{0}};
{name}_output output;

{name}_start(&state);
{example}
input.gravity[2] = -9.81;
if ({name}_evaluate(&input, &state, &output) == {name.upper()}_OK) {{
    /* use output */
}}
```

Inputs, besides `load[6]` [N, N m] on the platform about o and `gravity[3]` [m/s2], both in world axes:

{inputs}

Outputs{where}, besides `residual`, the largest residual of the equations of the loops [m or rad]:

{outputs}

{derivatives}| status | | |
|---|---:|---|
{statuses}

{floats}A call follows the straight line of coordinates from the last pose to the new one, so that the robot remains in its
assembly mode; one step is enough if both are close to each other, as in a controller. There are at most
`{name.upper()}_MOST_STEPS` (200) steps, each with at most {MOST_CORRECTIONS} corrections of
{parts.line.newton.operations:,} operations; the analysis takes {parts.pose.operations:,} operations.
Close to a singular pose, some lines that Python can follow give UNREACHABLE.
The work array takes {8 * parts.work:,} bytes of the stack.
{_searching(parts)}
```sh
cmake -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build && ctest --test-dir build
```

builds the library and a test program that compares it with Python's results at some poses, in and out of reach.

## How long a call takes

Operations, counted:

{_operations(parts)}

A call near the last pose is one step of a line. `state.corrections` counts the corrections of the loops. Operations that set up
lines and copy states are not in the table{outside}.

The test program (`build/{name}_test`) also measures calls with small steps about reference poses, on the machine on which it
runs: corrections of the loops per call, time by `clock()`, and time stamps of an x86 processor or cycles of a Cortex-M
(`DWT->CYCCNT`). For your own controller compile {name}.c and {name}_test.c with its compiler and options and run the program
there; on a Cortex-M without an operating system, printing needs semihosting, for instance.
"""


def _searching(parts: Programs) -> str:
    if parts.search is None:
        return ""
    return f"""
From the target pose, Broyden's method searches for the commanded pose of the unloaded robot, with the same operations as
`kinetostatics.compensate`: at most {MOST} iterations, each with a line, an analysis and
{parts.search.update.operations:,} further operations. Then the actuators follow a straight line from the target pose to the
positions found; unless the loaded platform arrives at its target pose, the status is UNREACHABLE.
"""


def _operations(parts: Programs) -> str:
    """Return a table of the C functions: how often each is called, and its operations by kind."""
    steps = f": 1 to {MOST_CORRECTIONS}"
    often = {"start of a line": "a line, if its angles are not unique"}
    for what, line in (("", "step of the line"), (", actuators given", "step of the actuators' line")):
        often |= {f"correction of the loops{what}": f"{line}{steps}", f"test for singular poses{what}": line}
    if parts.search is not None:
        often |= {
            "frames, statics, actuators": "2, and each step of the search",
            "step of the search": f"1 to {MOST + 1}",
        }
    if parts.jacobian is not None:
        inputs = {value.name: size(value) for _, value, _ in parts.jacobian.pairs}
        often["derivatives: results"] = str(sum(inputs.values()))
    rows = [f"| function | how often | {' | '.join(_KINDS)} | comparisons, choices |", f"|---|---|{'---:|' * (len(_KINDS) + 1)}"]
    for what, program in parts.all:
        numbers = [sum(program.counts.get(kind, 0) for kind in kinds) for kinds in _KINDS.values()]
        numbers.append(program.operations - sum(numbers))
        rows.append(f"| {what} | {often.get(what, '1')} | {' | '.join(f'{number:,}' for number in numbers)} |")
    return "\n".join(rows)


def filled(templates: Iterable[Path], words: Mapping[str, str]) -> str:
    """Return the joined templates, with the words in capitals replaced."""
    text = "".join(template.read_text("utf-8") for template in templates)
    return re.sub("|".join(words), lambda word: words[word[0]], text)
