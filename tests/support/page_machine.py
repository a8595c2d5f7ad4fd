"""The machine of a page that computes (engine.js), run by Node.js instead of a browser."""

import json
import shutil
import subprocess
from importlib.resources import files

import numpy as np
import pytest

from kinetostatics.viewer.computing import computing_page

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
_SCRIPT = """
const text = (async () => { let all = ""; for await (const part of process.stdin) all += part; return all; })();
text.then(async (all) => {
  const { data, calls } = JSON.parse(all), machine = await Machine.load(data), answers = [];
  for (const call of calls) answers.push(new Function("machine", "given", call.script)(machine, call.given));
  const finite = (value) => (typeof value === "number" && !Number.isFinite(value) ? null : value);
  const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : finite(value));
  process.stdout.write(JSON.stringify(answers, plain));
});
"""


def answers(result, calls, **how):
    """Return what scripts return, each a pair of JavaScript that knows ``machine`` and ``given``, and of what is given."""
    assets = files("kinetostatics.viewer") / "assets"
    source = "".join((assets / name).read_text(encoding="utf-8") for name in ("unpacking.js", "engine.js")) + _SCRIPT
    question = {"data": computing_page(result, **how), "calls": [{"script": script, "given": given} for script, given in calls]}
    run = subprocess.run(
        ["node", "-e", source], input=json.dumps(question), capture_output=True, text=True, timeout=300, check=False
    )
    assert run.returncode == 0, run.stderr[-3000:]
    return json.loads(run.stdout)


def relative(found, expected, size=None):
    """Return the largest difference of two arrays, relative to the largest expected entry or to a size."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    size = np.max(np.abs(expected), initial=0.0) if size is None else size
    return np.max(np.abs(found - expected), initial=0.0) / (size or 1.0)
