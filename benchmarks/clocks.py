"""Clocks, and what machine they ran on. Import it before NumPy: it sees to it that NumPy's libraries use one thread."""

from __future__ import annotations

import gc
import importlib.metadata
import importlib.util
import os
import platform
import re
import resource
import shlex
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
os.environ.update(dict.fromkeys(ONE_THREAD, "1"))

PACKAGES = ("kinetostatics", "pin", "numpy", "openseespy", "xarray", "h5netcdf", "dask", "distributed")


def cpu() -> float:
    """Return the processor time that this process and those that it has waited for have used [s]."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def peak_memory() -> int:
    """Return the most memory that this process has had in use [bytes], on Linux without what its parent had."""
    try:
        found = re.search(r"^VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        found = None
    kibibytes = found.group(1) if found else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(kibibytes) * 1024


def interleaved(
    runs: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = time.process_time
) -> dict[str, float]:
    """Return the shortest time of each call [s]; all are called in turn, again and again, after one turn to warm up.

    Other processes of the machine disturb all of them alike, and the shortest time is the least disturbed.
    """
    best = dict.fromkeys(runs, float("inf"))
    for turn in range(repeats + 1):
        for name, run in runs.items():
            gc.collect()
            start = clock()
            run()
            if turn:
                best[name] = min(best[name], clock() - start)
    return best


def processor() -> str:
    """Return the name of the processor."""
    name = re.search(r"^Model name:\s*(.+)$", _said("lscpu"), re.MULTILINE)
    return name.group(1) if name else platform.processor() or platform.machine()


def commit() -> str:
    """Return the commit of the source that is measured."""
    return _said("git", "describe", "--always", "--dirty")


def today() -> str:
    """Return the date."""
    return time.strftime("%Y-%m-%d", time.gmtime())


def origin() -> str:
    """Return a line about where numbers come from: the command, the machine, the source and the day."""
    command = shlex.join(["python", os.path.relpath(sys.argv[0], Path(__file__).parent.parent), *sys.argv[1:]])
    return f"`{command}`, {processor()}, commit {commit()}, {today()}."


def machine() -> list[str]:
    """Return what the measurements run on, one fact a line."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    versions = [f"{name} {importlib.metadata.version(name)}" for name in PACKAGES if importlib.util.find_spec(_module(name))]
    return [
        f"processor: {processor()}, {os.cpu_count()} cores, {memory:.0f} GiB of memory; {platform.system()}",
        f"versions: Python {platform.python_version()}, {', '.join(versions)}; commit {commit()}",
        f"{' = '.join(ONE_THREAD)} = 1",
    ]


def _module(distribution: str) -> str:
    return {"pin": "pinocchio"}.get(distribution, distribution)


def _said(*command: str) -> str:
    """Return what a command prints, nothing if there is no such command."""
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, env=environment)
    except OSError:
        return ""
    return done.stdout.strip()
