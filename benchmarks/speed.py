"""How long one pose, a batch of poses and the command take, on this machine, next to a yardstick measured in the same run.

    python benchmarks/speed.py [--poses 10000] [--repeats 7]

The yardstick is Pinocchio's ``forwardKinematics`` of the 3RPS tree, called from Python: timings of one machine mean little
elsewhere, their ratios somewhat more.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):  # one core, before NumPy is loaded
    os.environ.setdefault(name, "1")

import numpy as np
import pinocchio as pin

import kinetostatics as ks

ROBOTS = Path(__file__).resolve().parent.parent / "robots"


def seconds(run: Callable[[], object], repeats: int) -> float:
    """Return the median time of a call [s], after one call to warm up."""
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def everything(result: ks.Result) -> None:
    """Ask for all of a result."""
    for attribute in ("status", "twist", "contributions", "stiffness", "compliance", "limbs", "actuator_forces",
                      "joint_wrenches", "base_wrench", "beams", "warnings"):  # fmt: skip
        getattr(result, attribute)


def poses(name: str, count: int) -> dict[str, object]:
    """Return random coordinates inside a robot's workspace."""
    random = np.random.default_rng(0)
    if name == "3rps":
        return {"platform": {"z": random.uniform(0.35, 0.7, count), "rx": random.uniform(-0.2, 0.2, count),
                             "ry": random.uniform(-0.2, 0.2, count)}}  # fmt: skip
    return {"platform": {"z": random.uniform(0.3, 0.6, count), "rx": random.uniform(-0.17, 0.17, count),
                         "ry": random.uniform(-0.17, 0.17, count)}, "orientation": "XYZ"}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--repeats", type=int, default=7)
    args = parser.parse_args()

    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}, "
          f"pin {pin.__version__}, one core")  # fmt: skip
    robots = {name: ks.load_robot(ROBOTS / f"{name}.urdf.xacro") for name in ("3rps", "2pru_upr")}
    model = robots["3rps"].model
    data, q = model.createData(), pin.neutral(model)

    def yardstick() -> None:
        for _ in range(10_000):
            pin.forwardKinematics(model, data, q)

    unit = seconds(yardstick, args.repeats) / 10_000
    print(f"yardstick: pin.forwardKinematics called from Python {unit * 1e6:.2f} µs")

    def say(what: str, value: float, scale: float, suffix: str) -> None:
        print(f"{what:58s} {value * scale:9.2f} {suffix}  = {value / unit:9.0f} yardsticks")

    for name, robot in robots.items():
        single = {key: {k: float(v[0]) for k, v in value.items()} if key == "platform" else value
                  for key, value in poses(name, 1).items()}  # fmt: skip
        twist = seconds(lambda r=robot, s=single: ks.analyze(r.assemble(**s)).twist, 30 * args.repeats)
        say(f"{name}: one pose, loops closed, twist", twist, 1e3, "ms")
        whole = seconds(lambda r=robot, s=single: everything(ks.analyze(r.assemble(**s))), 30 * args.repeats)
        say(f"{name}: one pose, loops closed, all of the result", whole, 1e3, "ms")
        many = poses(name, args.poses)

        def batch(robot: ks.Robot = robot, many: dict[str, object] = many) -> None:
            result = ks.analyze(robot.assemble(**many))
            result.twist, result.contributions, result.stiffness, result.limbs, result.actuator_forces, result.status

        say(f"{name}: {args.poses} poses: twist, stiffness, limbs, forces", seconds(batch, args.repeats) / args.poses, 1e6, "µs")

        def whole_batch(robot: ks.Robot = robot, many: dict[str, object] = many) -> None:
            everything(ks.analyze(robot.assemble(**many)))

        say(f"{name}: {args.poses} poses: all, bent lines of beams too",
            seconds(whole_batch, max(args.repeats // 2, 1)) / args.poses, 1e6, "µs")  # fmt: skip
    command = [sys.executable, "-m", "kinetostatics", "analyze", str(ROBOTS / "3rps.urdf.xacro")]
    say("kinetostatics analyze 3rps, from start to end",
        seconds(lambda: subprocess.run(command, check=True, capture_output=True), args.repeats), 1, " s")  # fmt: skip


if __name__ == "__main__":
    main()
