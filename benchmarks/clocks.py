"""Clocks, and what machine they ran on. Import it before NumPy: it sees to it that NumPy's libraries use one thread."""

from __future__ import annotations

import gc
import importlib.metadata
import os
import platform
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
for _name in ONE_THREAD:
    os.environ[_name] = "1"

PACKAGES = ("kinetostatics", "pin", "numpy", "openseespy", "xarray", "h5netcdf", "dask", "distributed")


def cpu() -> float:
    """Return the processor time that this process and those that it has waited for have used [s]."""
    here, ended = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return here.ru_utime + here.ru_stime + ended.ru_utime + ended.ru_stime


def peak_memory() -> int:
    """Return the most memory that this process has had in use [bytes]."""
    try:  # ru_maxrss would count what the process that started this one had in use
        status = Path("/proc/self/status").read_text(encoding="utf-8")
    except OSError:
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return most if sys.platform == "darwin" else most * 1024
    found = re.search(r"^VmHWM:\s*(\d+) kB", status, re.MULTILINE)
    return int(found.group(1)) * 1024 if found else 0


def seconds(run: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return what a call takes [s]."""
    gc.collect()
    start = clock()
    run()
    return clock() - start


def interleaved(
    runs: Mapping[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = time.process_time
) -> dict[str, float]:
    """Return the shortest time of each call [s]; all are called in turn, again and again, after one turn to warm up.

    Other processes of the machine disturb all of them alike, and the shortest time is the least disturbed.
    """
    best = dict.fromkeys(runs, float("inf"))
    for turn in range(repeats + 1):
        for name, run in runs.items():
            taken = seconds(run, clock)
            if turn:
                best[name] = min(best[name], taken)
    return best


def machine() -> list[str]:
    """Return what the measurements ran on, one fact a line."""
    lines = [f"processor: {_processor()}, {os.cpu_count()} cores, {_memory():.0f} GiB of memory; {platform.system()}"]
    versions = [f"Python {platform.python_version()}"]
    for name in PACKAGES:
        try:
            versions.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            versions.append(f"no {name}")
    lines.append(f"versions: {', '.join(versions)}; commit {_commit()}")
    lines.append(f"{' = '.join(ONE_THREAD)} = 1")
    return lines


def load_average() -> float:
    """Return how many processes want a core, averaged over the last minute."""
    return os.getloadavg()[0]


def _processor() -> str:
    try:
        told = subprocess.run(["lscpu"], capture_output=True, text=True, check=True, env={**os.environ, "LC_ALL": "C"}).stdout
        name = re.search(r"^Model name:\s*(.+)$", told, re.MULTILINE)
        family = re.search(r"^CPU family:\s*(.+)$", told, re.MULTILINE)
    except (OSError, subprocess.CalledProcessError):
        return platform.processor() or platform.machine()
    found = name.group(1) if name else platform.machine()
    try:
        clock = re.search(r"^cpu MHz\s*:\s*(\d+)", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        clock = None
    if family:
        found += f" (family {family.group(1)})"
    return found + (f", {int(clock.group(1)) / 1000:.1f} GHz" if clock else "")


def _memory() -> float:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30


def _commit() -> str:
    folder = Path(__file__).resolve().parent
    try:
        told = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=folder, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return told.stdout.strip()
