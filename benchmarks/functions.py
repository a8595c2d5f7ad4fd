"""How long a call of a compiled function takes beside the last pose, and the ways that do the same with more care or in batches.

    python benchmarks/functions.py [--write docs/how_to/functions.md] [ROBOT …]

Processor times; the shortest of several counts, because other processes can only make them longer. The platform goes back and
forth by a hundredth of a characteristic length, or of a radian, from where it was at the last call.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import clocks
from beside import ORIENTATION, ROBOTS, Around, determining
from page import measured

import kinetostatics as ks

#: How often each is measured, and how often one pose is computed each time.
TIMES, OFTEN = 8, 200
#: By how much the platform moves, in characteristic lengths and rad.
STEP = 0.01
HEAD = (
    "twist and actuator forces, µs",
    "short way",
    "with azimuth, tilt, torsion",
    "`assemble` and `analyze`, compiled",
    "NumPy",
    "one of 20,000 in a batch",
)


class Moving:
    """A platform that goes back and forth along one coordinate.

    Attributes:
        one: the coordinates in the middle of its way.
        key, step: along which it goes, and how far.
    """

    def __init__(self, one: Mapping[str, float], key: str, length: float) -> None:
        self.one, self.key, self.step = one, key, STEP * (length if key in "xyz" else 1.0)

    def goes(self, pose_at: Callable[[dict[str, float], object], object], start: object, times: int) -> Callable[[], None]:
        """Return what computes so many poses, each from the one before; the first from ``start``."""
        last = start

        def go() -> None:
            nonlocal last
            for k in range(times):
                last = pose_at({**self.one, self.key: self.one[self.key] + self.step * (k % 2)}, last)

        return go


def called(
    around: Around, pose: ks.Configuration, orientation: str, engine: str
) -> tuple[Moving, Callable[[int], Callable[[], None]]]:
    """Return a platform that moves, and what calls a function of it so many times."""
    names = determining(around.robot, pose, orientation, turned=True)
    at = {name: float(value) for name, value in pose.platform_coordinates(orientation).items() if name in names}
    moving = Moving(at, names[-1], around.robot.length)
    f = ks.compile(around.robot, names, orientation=orientation, engine=engine)
    first = f(**at, near=pose)
    if first["status"] > ks.Status.LIMIT_EXCEEDED:
        raise SystemExit(f"{around.robot.name}: the pose to be measured has the status {int(first['status'])}")
    return moving, lambda times: moving.goes(lambda values, near: f(**values, near=near), first, times)


def row(name: str) -> list[str]:
    """Return a robot's line of the table."""
    around = Around.of(name)
    pose = around.robot.assemble(platform=around.one, orientation=ORIENTATION, near=around.near, engine="numpy")
    moving, short = called(around, pose, ORIENTATION, "compiled")
    runs = {"short": (short(OFTEN), OFTEN)}
    if any(name not in "xyz" for name in determining(around.robot, pose, "tilt_torsion", turned=True)):
        runs["tilt"] = called(around, pose, "tilt_torsion", "compiled")[1](OFTEN), OFTEN

    def careful(values: dict[str, float], near: object) -> object:
        there = around.robot.assemble(platform=values, orientation=ORIENTATION, near=near, engine="compiled")
        result = ks.analyze(there, engine="compiled")
        result.twist, dict(result.actuator_forces)
        return there

    runs["careful"] = moving.goes(careful, pose, OFTEN // 10), OFTEN // 10
    runs["numpy"] = called(around, pose, ORIENTATION, "numpy")[1](2), 2
    f = ks.compile(around.robot, around.names, orientation=ORIENTATION, engine="compiled")
    size = len(next(iter(around.many.values())))
    runs["batch"] = (lambda: f(**around.many, near=around.near)), size
    best = clocks.interleaved({key: run for key, (run, _) in runs.items()}, TIMES)
    each = {key: 1e6 * best[key] / count for key, (_, count) in runs.items()}
    ways = [f"{each[key]:,.0f}, {each[key] / each['short']:.0f} ×" for key in ("careful", "numpy")]
    return [f"`{name}`", f"{each['short']:.0f}", f"{each['tilt']:.0f}" if "tilt" in each else "–", *ways, f"{each['batch']:.1f}"]


def main() -> None:
    """Measure, and print the table or write it into a page."""
    measured(__doc__, HEAD, row, "calls", ROBOTS)


if __name__ == "__main__":
    main()
