"""What is tested with NumPy holds with compiled code too: loops that are followed, assembly modes of maps, degenerate poses."""

import os
import subprocess
import sys

import pytest
from places import ROOT

FILES = ["properties/test_continuation.py", "maps/test_sweep_modes.py", "unit/statics/test_degenerate_poses.py"]


@pytest.mark.slow
def test_tests_of_loops_and_of_degenerate_poses_pass_with_compiled_code(cache):
    """But for those that are about NumPy's own way, which have the fixture ``by_numpy``."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *(f"tests/{name}" for name in FILES)]
    environment = {**os.environ, "KINETOSTATICS_ENGINE": "compiled", "KINETOSTATICS_CACHE": str(cache), "CI": "true"}
    environment = {name: value for name, value in environment.items() if not name.startswith("PYTEST")}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    # and compiled code was what computed
    assert len(list(cache.glob("*.code"))) > 50
