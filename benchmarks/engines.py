"""What compiled code brings: NumPy, compiled code and Pinocchio alternately, in one process and on one core.

    python benchmarks/engines.py [--write docs/how_to/compiled.md] [ROBOT …]

Processor times; the shortest of several counts, because other processes can only make them longer. All poses are given by
coordinates of the platform around its zero, or around the pose that :data:`MIDDLES` has, and loops are closed for every one.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin

import kinetostatics as ks
from kinetostatics.kinematics.coordinate_choices import choices
from kinetostatics.math.orientation import orientation_named

#: Poses of a map, and half its width along lengths, in characteristic lengths, and angles [rad].
MANY, WIDE = 20_000, (0.05, 0.1)
#: Where poses lie of robots whose zero pose is singular or has stretched legs, so that hardly a pose around it can be reached:
#: coordinates of the platform, or of the actuators in their order.
MIDDLES = {
    "anymal_standing": {"x": 0.0, "y": 0.0, "z": 0.45, "rx": 0.0, "ry": 0.0, "rz": 0.0},
    "ur10": (0.3, -1.0, 1.2, -0.9, -1.2, 0.4),
}
#: How often each is measured, and how often one pose is computed each time.
TIMES, OFTEN = 5, 20


def shortest(*functions: Callable[[], object], times: int = TIMES) -> list[float]:
    """Return the shortest processor times [s] of functions, called in turn."""
    best = [float("inf")] * len(functions)
    for _ in range(times):
        for k, function in enumerate(functions):
            start = time.process_time()
            function()
            best[k] = min(best[k], time.process_time() - start)
    return best


def once(function: Callable[[], object]) -> float:
    """Return the processor time [s] of a function that is called for the first time."""
    start = time.process_time()
    function()
    return time.process_time() - start


def middle_of(name: str) -> tuple[ks.Robot, ks.Configuration]:
    """Return a robot, and the pose around which it is measured."""
    robot, middle = ks.load_robot(name), MIDDLES.get(name)
    if isinstance(middle, dict):
        return robot, robot.assemble(platform=middle, orientation="XYZ", engine="numpy")
    actuators = None if middle is None else dict(zip(robot.description.driven, middle, strict=True))
    return robot, robot.assemble(actuators=actuators, engine="numpy")


def row(name: str) -> str:
    """Return a robot's line of the table."""
    robot, middle = middle_of(name)
    near = middle if name in MIDDLES else None
    names = choices(robot, orientation_named("XYZ"), (), middle.poses)[0]
    zero = middle.platform_coordinates("XYZ")
    random = np.random.default_rng(0)
    wide = {key: WIDE[0] * robot.length if key in "xyz" else WIDE[1] for key in names}
    many = {key: float(zero[key]) + wide[key] * random.uniform(-1, 1, MANY) for key in names}
    one = {key: float(values[0]) for key, values in many.items()}

    def twists(coordinates: dict[str, object], engine: str) -> object:
        poses = robot.assemble(platform=coordinates, orientation="XYZ", near=near, engine=engine, on_failure="nan")
        return ks.analyze(poses, engine=engine, on_failure="nan").twist

    twists(one, "numpy")
    making = once(lambda: twists(one, "compiled"))
    again, there = middle_of(name)
    start = there if name in MIDDLES else None
    poses = again.assemble(platform=one, orientation="XYZ", near=start, engine="numpy", on_failure="nan")
    ks.analyze(poses, engine="numpy", on_failure="nan")
    found = once(lambda: again.assemble(platform=one, orientation="XYZ", near=start, engine="compiled", on_failure="nan"))
    found += once(lambda: ks.analyze(poses, engine="compiled", on_failure="nan"))
    alone = [
        t / OFTEN
        for t in shortest(*(lambda e=e: [twists(one, e) for _ in range(OFTEN)] for e in ("numpy", "compiled")))  # type: ignore[misc]
    ]
    model, pool = robot.model, pin.ModelPool(robot.model, 1)
    q = np.asfortranarray(np.repeat(middle.q[:, None], MANY, axis=1))
    rest, torque = np.zeros((model.nv, MANY), order="F"), np.zeros((model.nv, MANY), order="F")
    batch = [
        1e6 * t / MANY
        for t in (
            *shortest(lambda: twists(many, "numpy"), times=2),
            *shortest(
                lambda: twists(many, "compiled"), lambda: pin.rneaInParallel(1, pool, q, rest, rest, torque), times=4 * TIMES
            ),
        )
    ]
    return (
        f"| `{name}` | {1e3 * alone[0]:.1f} → {1e3 * alone[1]:.2f} ms, {alone[0] / alone[1]:.0f} × | "
        f"{batch[0]:.0f} → {batch[1]:.1f} µs, {batch[0] / batch[1]:.0f} × | {batch[2]:.1f} µs | {batch[1] / batch[2]:.1f} | "
        f"{making:.1f} s | {1e3 * found:.0f} ms |"
    )


def main() -> None:
    """Measure, and print the table or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=[str(robot) for robot in ks.robots()])
    parser.add_argument("--write", type=Path)
    args = parser.parse_args()
    lines = [
        f"| robot | one pose, NumPy → compiled | one of {MANY:,} | RNEA | times RNEA | making the code | from the disk |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["KINETOSTATICS_CACHE"] = folder
        for name in args.robots:
            lines.append(row(name))
            print(lines[-1], flush=True)
    if args.write:
        table = "\n".join(["<!-- engines: begin -->", "", *lines, "", "<!-- engines: end -->"])
        page = args.write.read_text(encoding="utf-8")
        page = re.sub("<!-- engines: begin -->.*<!-- engines: end -->", lambda _: table, page, flags=re.DOTALL)
        args.write.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
