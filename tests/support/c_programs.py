"""Exported C, compiled strictly and asked about many poses."""

import shutil
import subprocess

import numpy as np
import pytest

NEEDS_ARM = pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="arm-none-eabi-gcc is not installed")
STRICT = ("-std=c99", "-O0", "-Wall", "-Wextra", "-Wconversion", "-Werror")
SANITIZED = ("-fsanitize=undefined,address", "-fno-sanitize-recover=all")

#: Reads coordinates, load and gravity of one pose after the other, starts anew or goes on, and writes status and outputs.
_DRIVER = """
#include "robot.h"
#include <stdio.h>
int main(int argc, char **argv)
{
    robot_state state;
    robot_input input;
    robot_output output;
    (void)argv;
    robot_start(&state);
    while (fread(&input, sizeof input, 1, stdin) == 1) {
        double status;
        if (argc == 1) robot_start(&state);
        status = (double)robot_evaluate(&input, &state, &output);
        if (fwrite(&status, sizeof status, 1, stdout) != 1 || fwrite(&output, sizeof output, 1, stdout) != 1) return 1;
    }
    return 0;
}
"""


def compiled(folder, *files, flags=()):
    subprocess.run(["gcc", *STRICT, *flags, *files, "-lm", "-o", "program"], cwd=folder, check=True)
    return folder / "program"


def driver(exported, flags=(), derivatives=False):
    """Return a program that evaluates poses with an exported function, also their derivatives, which stand last."""
    name, text = exported.name, _DRIVER
    if derivatives:
        text = text.replace("output;\n", "output;\n    robot_jacobian jacobian;\n").replace("evaluate", "differentiate")
        text = text.replace("&output)", "&output, &jacobian)")
        written = "fwrite(&output, sizeof output, 1, stdout) != 1"
        text = text.replace(written, f"{written} || {written.replace('output', 'jacobian')}")
    (exported.folder / "driver.c").write_text(text.replace("robot", name))
    return compiled(exported.folder, "driver.c", f"{name}.c", flags=flags)


def run(program, inputs, *arguments):
    """Return the statuses (N,) and outputs (N, k) of poses."""
    answer = subprocess.run([program, *arguments], input=inputs.tobytes(), capture_output=True, check=True)
    assert answer.stderr == b""
    rows = np.frombuffer(answer.stdout).reshape(len(inputs), -1)
    return rows[:, 0].astype(int), rows[:, 1:]


def around(f, N, size, seed, load=100.0):
    """Return coordinates around the zero pose, off by at most ``size``, times the robot's length or in rad; loads and gravity."""
    rng = np.random.default_rng(seed)
    zero = f.robot.solver.values(f.prescribed, f.robot.zero_poses)[:, 0]
    unit = [f.robot.length if f.inputs[name].units == ("m",) else 1.0 for name in f.names]
    steps = size * rng.uniform(-1, 1, (len(f.names), N))
    at = {name: value + by * step for name, value, by, step in zip(f.names, zero, unit, steps, strict=True)}
    return at, rng.uniform(-load, load, (N, 6)), rng.uniform(-10, 10, (N, 3))


def rows(f, at, load, gravity):
    """Return the inputs (N, k) that :func:`run` takes."""
    given = {**at, "load": load, "gravity": gravity}
    return np.column_stack([given[name] for name in f.inputs])


def on_cortex_m7(folder, *files):
    """Compile strictly for a Cortex-M7; return how many bytes the last file takes: code, data, and memory that begins with 0."""
    target = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-mthumb")
    options = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror")
    subprocess.run(["arm-none-eabi-gcc", *target, *options, "-c", *files], cwd=folder, check=True)
    command = ["arm-none-eabi-size", f"{files[-1].removesuffix('.c')}.o"]
    size = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return tuple(map(int, size.stdout.splitlines()[1].split()[:3]))
