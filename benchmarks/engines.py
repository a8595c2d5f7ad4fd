"""What compiled code brings: NumPy, compiled code and Pinocchio alternately, in one process and on one core.

    python benchmarks/engines.py [--write docs/how_to/compiled.md] [ROBOT …]

Processor times; the shortest of several counts, because other processes can only make them longer. All poses are given by
coordinates of the platform around its zero, or around the pose that ``beside.MIDDLES`` has, and loops are closed for every one.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import clocks
import numpy as np
import pinocchio as pin
from beside import MANY, ORIENTATION, ROBOTS, Around
from page import measured

import kinetostatics as ks

#: How often each is measured, and how often one pose is computed each time.
TIMES, OFTEN = 5, 20
HEAD = (
    "robot",
    "one pose, NumPy → compiled",
    f"one of {MANY:,}",
    "RNEA",
    "times RNEA",
    "making the code",
    "from the disk",
)


def once(function: Callable[[], object]) -> float:
    """Return the processor time [s] of a function that is called for the first time."""
    start = time.process_time()
    function()
    return time.process_time() - start


def row(name: str) -> list[str]:
    """Return a robot's line of the table."""
    around = Around.of(name)
    one, many = around.one, around.many

    def twists(coordinates: dict[str, object], engine: str) -> object:
        poses = around.robot.assemble(
            platform=coordinates, orientation=ORIENTATION, near=around.near, engine=engine, on_failure="nan"
        )
        return ks.analyze(poses, engine=engine, on_failure="nan").twist

    twists(one, "numpy")
    making = once(lambda: twists(one, "compiled"))
    again = Around.of(name)
    given = {"platform": one, "orientation": ORIENTATION, "near": again.near, "on_failure": "nan"}
    poses = again.robot.assemble(**given, engine="numpy")
    ks.analyze(poses, engine="numpy", on_failure="nan")
    found = once(lambda: again.robot.assemble(**given, engine="compiled"))
    found += once(lambda: ks.analyze(poses, engine="compiled", on_failure="nan"))
    runs = {e: (lambda e=e: [twists(one, e) for _ in range(OFTEN)]) for e in ("numpy", "compiled")}
    alone = {key: seconds / OFTEN for key, seconds in clocks.interleaved(runs, TIMES).items()}
    model, pool = around.robot.model, pin.ModelPool(around.robot.model, 1)
    q = np.asfortranarray(np.repeat(around.middle.q[:, None], MANY, axis=1))
    rest, torque = np.zeros((model.nv, MANY), order="F"), np.zeros((model.nv, MANY), order="F")
    batch = clocks.interleaved({"numpy": lambda: twists(many, "numpy")}, 2)
    batch |= clocks.interleaved(
        {"compiled": lambda: twists(many, "compiled"), "rnea": lambda: pin.rneaInParallel(1, pool, q, rest, rest, torque)},
        4 * TIMES,
    )
    each = {key: 1e6 * seconds / MANY for key, seconds in batch.items()}
    return [
        f"`{name}`",
        f"{1e3 * alone['numpy']:.1f} → {1e3 * alone['compiled']:.2f} ms, {alone['numpy'] / alone['compiled']:.0f} ×",
        f"{each['numpy']:.0f} → {each['compiled']:.1f} µs, {each['numpy'] / each['compiled']:.0f} ×",
        f"{each['rnea']:.1f} µs",
        f"{each['compiled'] / each['rnea']:.1f}",
        f"{making:.1f} s",
        f"{1e3 * found:.0f} ms",
    ]


def main() -> None:
    """Measure, and print the table or write it into a page."""
    measured(__doc__, HEAD, row, "engines", ROBOTS)


if __name__ == "__main__":
    main()
