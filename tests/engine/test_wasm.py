"""Operations in WebAssembly against NumPy, run by Node.js: single operations, and records whose values pass between functions."""

import base64
import json
import shutil
import subprocess

import numpy as np
import pytest
from tapes import FIRST, SECOND, evaluate, recorded

from kinetostatics.engine import wasm
from kinetostatics.engine.scalars import Tape, choose, compare, logical_and, logical_not

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")

_RUN = """
const { module, poses, outputs } = JSON.parse(require("fs").readFileSync(0)), bytes = Buffer.from(module, "base64");
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(bytes), { math: Math }), found = [];
const numbers = new Float64Array(exports.memory.buffer);
for (const pose of poses) {
  const given = Buffer.from(pose, "base64");
  new Uint8Array(exports.memory.buffer).set(given);
  exports.run();
  found.push(Buffer.from(numbers.slice(0, given.length / 8 + outputs).buffer).toString("base64"));
}
console.log(JSON.stringify(found));
"""


def run(module, inputs, outputs):
    """Return the outputs (outputs, N) of a module for inputs (components, N)."""
    poses = [base64.b64encode(np.ascontiguousarray(pose).tobytes()).decode() for pose in inputs.T]
    question = {"module": base64.b64encode(module).decode(), "poses": poses, "outputs": outputs}
    done = subprocess.run(["node", "-e", _RUN], input=json.dumps(question), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = [np.frombuffer(base64.b64decode(text))[len(inputs) :] for text in json.loads(done.stdout)]
    return np.array(found).T


@pytest.mark.parametrize("kind", ["input", "parameter"])
def test_webassembly_of_operations_equals_numpy(kind):
    """Up to rounding of sine, cosine and arctangent; of all others bit by bit."""
    tape, numbers, truths = recorded(kind)
    given = np.array([FIRST, SECOND])
    rows = [*numbers, *truths]
    found = run(wasm.wasm_module(tape, rows, [2, 0] if kind == "input" else [0, 2]), given, len(rows))
    wanted = np.vstack([evaluate(tape, [given], given, numbers), evaluate(tape, [given], given, truths)])
    for row, number in enumerate(rows):
        exact = tape.operations[number][0] not in ("sine", "cosine", "angle")
        np.testing.assert_allclose(found[row], wanted[row], rtol=0 if exact else 6e-16, atol=0 if exact else 1e-15)
        if exact:
            known = ~np.isnan(wanted[row])
            np.testing.assert_array_equal(np.signbit(found[row][known]), np.signbit(wanted[row][known]))


@pytest.mark.parametrize("piece", [1, 3, 50, 2000])
def test_values_pass_between_functions(piece, monkeypatch):
    """A random record: numbers and truth values that are used at once, later, often or in other functions."""
    monkeypatch.setattr(wasm, "_PIECE", piece)
    rng = np.random.default_rng(3)
    tape = Tape()
    scalars = [tape.write(("input", k // 2, k % 2), 0.3 * k - 0.5) for k in range(4)]
    flags = [compare(">", scalars[0], scalars[1])]
    for k in range(200):
        a, b = (scalars[n] for n in rng.choice(len(scalars), 2))
        flag = flags[rng.integers(len(flags))]
        new = [a + b, a * b * 0.25, a - 0.7 * b, choose(flag, a, b), abs(a)][k % 5]
        scalars.append(new)
        flags.append([compare("<", new, b), logical_and(flag, compare("<=", a, new)), logical_not(flag)][k % 3])
    rows = [tape.number_of(value) for value in (*scalars[-40:], *flags[-20:], scalars[1], scalars[50], 0.125, True)]
    given = rng.uniform(-1, 1, (4, 30))
    found = run(wasm.wasm_module(tape, rows, [2, 2, 0]), given, len(rows))
    np.testing.assert_array_equal(found, evaluate(tape, [given[:2], given[2:]], [], rows))


def test_modules_are_the_same_every_time():
    tape, numbers, truths = recorded("input")
    first, second = (wasm.wasm_module(tape, [*numbers, *truths], [2, 0]) for _ in range(2))
    assert first == second
