"""What exported C takes and how near to Python it is: operations, times of calls, flash, and poses that both compute.

    python benchmarks/controllers.py [--write docs/how_to/controller.md] [ROBOT …]

Times are those of the test program that is exported, `gcc -O2`, beside the last pose; flash is that of a Cortex-M7 by
`arm-none-eabi-gcc -O2`. Poses lie around the zero pose, every fifth farther away. `ROBOT compensate` corrects the actuators'
positions too.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import clocks  # noqa: F401 - before NumPy, whose libraries are to use one thread
import numpy as np
from page import measured

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))
import c_programs

import kinetostatics as ks

ROBOTS = ("3rps", "2pru_upr", "gough_stewart", "3rps compensate", "2pru_upr compensate")
HEAD = (
    "robot", "operations of a correction", "of the statics", "corrections per call", "a call [µs]", "flash [kB]", "poses",
    "out of reach", "statuses that differ", "largest difference, relative",
)  # fmt: skip
#: Coordinates of the platform, and poses that are compared.
PLATFORM = {"five_bar": ("x", "y"), "gough_stewart": ("x", "y", "z", "rx", "ry", "rz")}
POSES, POSES_CORRECTED = 10_000, 1_000
ARM = ("arm-none-eabi-gcc", "-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-mthumb", "-O2", "-std=c99", "-c")


def exported_program(exported: ks.functions.CExport) -> str:
    """Compile the test program, and return what it prints."""
    files = [f"{exported.name}.c", f"{exported.name}_test.c"]
    subprocess.run(["gcc", "-std=c99", "-O2", *files, "-lm", "-o", "measure"], cwd=exported.folder, check=True)
    return subprocess.run([exported.folder / "measure"], capture_output=True, text=True, check=True).stdout


def flash(exported: ks.functions.CExport) -> str:
    """Return how much of a Cortex-M7's flash the code takes [kB]."""
    try:
        subprocess.run([*ARM, f"{exported.name}.c"], cwd=exported.folder, check=True)
    except FileNotFoundError:
        return "–"
    said = subprocess.run(
        ["arm-none-eabi-size", f"{exported.name}.o"], cwd=exported.folder, capture_output=True, text=True, check=True
    )
    return f"{int(said.stdout.splitlines()[1].split()[0]) / 1e3:.0f}"


def compared(
    f: ks.functions.Function, exported: ks.functions.CExport, outputs: Sequence[str], poses: int
) -> tuple[str, str, str]:
    """Return how many poses are out of reach, how many statuses differ, and the largest relative difference of an output."""
    at, load, gravity = c_programs.around(f, poses, np.where(np.arange(poses) % 5 == 0, 0.8, 0.15), 11, load=200.0)
    status, found = c_programs.run(c_programs.driver(exported, ("-O2",)), c_programs.rows(f, at, load, gravity))
    wanted = f(**at, load=load, gravity=gravity)
    exceeded = wanted["status"] == ks.Status.LIMIT_EXCEEDED
    python = wanted["status"] if f.compensates else np.where(exceeded, ks.Status.OK, wanted["status"])
    here, first, worst = (status == python) & np.isfinite(found).all(axis=1), 0, 0.0
    for name in outputs:
        expected = wanted[name][here]
        part = found[here, first : first + expected.shape[1]]
        first += expected.shape[1]
        if name != "residual_error":  # whose size is that of rounding where everything can be corrected
            size = np.max(np.abs(expected), axis=1)
            worst = max(worst, float(np.max(np.max(np.abs(part - expected), axis=1) / size)))
    return f"{int(np.sum(~np.isfinite(found).all(axis=1))):,}", f"{int(np.sum(status != python))}", f"{worst:.0e}"


def row(name: str) -> list[str]:
    """Measure a robot."""
    robot, _, corrected = name.partition(" ")
    outputs = ("actuators", "actuator_forces", "residual_error") if corrected else ("twist", "actuator_forces", "actuators")
    platform = PLATFORM.get(robot, ("z", "rx", "ry"))
    f = ks.compile(ks.load_robot(robot), platform, orientation="XYZ", outputs=outputs, compensate=bool(corrected))
    poses = POSES_CORRECTED if corrected else POSES
    with tempfile.TemporaryDirectory() as folder:
        exported = f.export_c(folder)
        said = exported_program(exported)
        corrections, time = (re.search(rf"([\d.e+-]+) {words}", said)[1] for words in ("corrections", "microseconds"))
        return [
            f"`{robot}`" + ", `--compensate`" * bool(corrected), *(f"{count:,}" for count in exported.operations),
            corrections, time, flash(exported), f"{poses:,}", *compared(f, exported, outputs, poses),
        ]  # fmt: skip


if __name__ == "__main__":
    measured(__doc__, HEAD, row, "controllers", ROBOTS)
