"""Ctrl+C: one line on standard error, during imports too, and how to continue a sweep."""

import os
import signal
import subprocess
import sys

import pytest

#: Interrupts the program when it imports a module for the first time, as Ctrl+C does; the module then raises its own error.
WHILE_IMPORTING = """
import importlib.abc, os, signal, sys, time
from kinetostatics.__main__ import run

class Interrupt(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == {name!r}:
            try:
                os.kill(os.getpid(), signal.SIGINT)
                time.sleep(1)
            except KeyboardInterrupt:
                raise {error} from None

sys.meta_path.insert(0, Interrupt())
sys.argv[1:] = ["analyze", "3rps"]
sys.exit(run())
"""


@pytest.mark.parametrize("error", ["KeyboardInterrupt", "ImportError('numpy._core.multiarray failed to import')"])
@pytest.mark.parametrize("name", ["kinetostatics.cli.main", "numpy", "pinocchio"])
def test_an_interruption_of_an_import_is_one_line(name, error):
    code = WHILE_IMPORTING.format(name=name, error=error)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "kinetostatics: interrupted\n")


def test_an_interrupted_sweep_tells_how_to_continue(tmp_path):
    grid = ["--platform", "z=0.45:0.65:41", "rx=-10deg:10deg:41", "ry=-10deg:10deg:41", "--out", "map.nc"]
    command = [sys.executable, "-m", "kinetostatics", "sweep", "3rps", *grid]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=tmp_path, start_new_session=True)
    while not list(tmp_path.glob("map.nc.part/twist/0*")):
        assert process.poll() is None
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode in (130, -signal.SIGINT)
    assert said == "kinetostatics: interrupted; the same command continues from map.nc.part\n"
