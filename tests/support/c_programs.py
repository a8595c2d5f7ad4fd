"""Exported C, compiled strictly and asked about many poses."""

import subprocess

import numpy as np

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
