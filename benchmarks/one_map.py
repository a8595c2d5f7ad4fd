"""One map in a process of its own, so that its memory can be told.

    python one_map.py dropped|stored ROBOT POSES REPEATS [FOLDER]

Prints one line of JSON: poses, seconds per pose, largest resident memory and size of the file in bytes.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import clocks
import grids
import numpy as np

#: Poses that are computed at once when their numbers are dropped.
AT_ONCE = 110_000


def main() -> None:
    how, name, poses, repeats = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    robot, workspace = grids.load(name), grids.WORKSPACES[name]
    axes = workspace.axes(poses)
    size = int(np.prod([len(values) for values in axes.values()]))
    first = next(iter(axes))
    layer = size // len(axes[first])
    step = max(1, AT_ONCE // layer)
    path = Path(sys.argv[5]) / "map.nc" if how == "stored" else None

    def run() -> None:
        if path is not None:
            grids.sweep(robot, workspace, axes, out=path, restart=True).close()
            return
        for start in range(0, len(axes[first]), step):
            grids.whole(robot, workspace, grids.mesh({**axes, first: axes[first][start : start + step]}))

    small = workspace.axes(300)
    grids.whole(robot, workspace, grids.mesh(small))
    if path is not None:
        grids.sweep(robot, workspace, small, out=path, restart=True).close()
    cpu = wall = float("inf")
    for _ in range(repeats):
        if path is not None:
            path.unlink()  # a map that is there already is looked at first
        cpu_before, before = clocks.cpu(), time.perf_counter()
        run()
        cpu, wall = min(cpu, clocks.cpu() - cpu_before), min(wall, time.perf_counter() - before)
    file = path.stat().st_size if path is not None else 0
    print(json.dumps({"poses": size, "cpu": cpu / size, "wall": wall / size, "memory": clocks.peak_memory(), "file": file}))


if __name__ == "__main__":
    main()
