"""Small mistakes, put into the numeric code one at a time: which of them do the tests notice?

    python tests/mutate.py                                   # a sample from every folder that computes numbers
    python tests/mutate.py engine statics/solution           # from this folder and this module
    python tests/mutate.py statics/solution --count 40 --seed 3 --jobs 2

Each mistake (a mutant) changes one thing, of one kind:

- arithmetic: an operator, a sign, a number, a statement left out;
- tolerance: a number below 1e-3 becomes a thousand times larger or smaller;
- condition: a comparison or a branch turned round, ``and`` for ``or``, a part of a condition left out;
- guard: a mask, a bound or ``np.where`` left out.

The kinds are drawn equally often, as far as a folder has them. The tests of a folder (``TESTS``) first run without mutants, in
the same copy of the package: tests that fail or are skipped there are named and left out, and the lines that the others reach
are noted. This is kept in ``build`` until the package or a test file changes. Then every mutant meets the tests that reach its
line, the quickest first, until one fails. Killed means that pytest says so (exit code 1); mutants that exceed the time or end
pytest in another way, as by an error of an import, are counted apart. What no test notices is listed; mutants that change nothing
a user could see are named with the reason in ``mutants_without_effect.txt`` and are not drawn. Needs ``coverage`` (in the extra
``test``) and a system that can fork.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import hashlib
import importlib
import json
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "src" / "kinetostatics"
MAPS = ROOT / "build" / "tests_of_lines"
WITHOUT_EFFECT = Path(__file__).parent / "mutants_without_effect.txt"
KINDS = ("arithmetic", "condition", "tolerance", "guard")

#: The folders in which a mistake makes a wrong number, and the files or folders of tests that are about them.
TESTS = {
    "math": "unit/math unit/kinematics/test_joint_coordinates.py unit/buckling unit/description",
    "sections": "unit/sections validation/test_section_shear.py",
    "description": "unit/description unit/files/test_joint_elements.py unit/files/test_robot_file.py unit/limbs"
    " validation/test_joint_matrices.py validation/test_flexible.py",
    "mechanism": "unit/mechanism",
    "kinematics": "unit/kinematics properties/test_zero_pose.py properties/test_loop_types.py",
    "elements": "unit/elements unit/limbs unit/vibration unit/buckling validation/test_beam_formulas.py"
    " validation/test_matrix_link.py validation/test_second_order.py validation/test_tangent.py validation/test_motion.py"
    " validation/test_telescopes_in_motion.py validation/test_vibration.py validation/test_flexible.py"
    " validation/test_flexible_ports.py",
    "condensation": "unit/condensation unit/description/test_link_matrices.py validation/test_flexible.py"
    " validation/test_flexible_ports.py",
    "limbs": "unit/limbs unit/statics validation/test_beam_formulas.py",
    "statics": "unit/statics validation/test_hybrid_limbs.py validation/test_motion.py validation/test_sprung_vibration.py"
    " validation/test_tangent.py validation/test_elastic_platform.py properties/test_energy.py",
    "buckling": "unit/buckling validation/test_second_order.py",
    "vibration": "unit/vibration validation/test_vibration.py validation/test_sprung_vibration.py",
    "engine": "engine functions/test_c_by_hand.py functions/test_c_export.py",
    "functions": "functions",
    "results": "unit/results unit/reports design/test_compensate.py design/test_trajectory.py design/test_optimize.py"
    " design/test_tolerances.py design/test_pareto.py design/test_sensitivities.py unit/statics/test_link_loads.py"
    " validation/test_sprung_vibration.py",
    "checks": "unit/checks cli/test_check_golden.py",
    "indices": "maps/test_indices.py maps/test_any_direction.py",
    "workspace": "unit/workspace maps/test_sweep.py maps/test_map_facts.py maps/test_store.py",
    "calibration": "unit/calibration design/test_calibrate.py design/test_plan.py",
    "design": "unit/design design/test_optimize.py design/test_pareto.py design/test_tolerances.py design/test_requirements.py"
    " design/test_sensitivities.py",
    "verification": "unit/verification validation/test_verification.py",
    "dynamics": "design/test_trajectory.py design/test_trajectory_profiles.py unit/reports/test_dynamics.py"
    " validation/test_motion.py validation/test_vibration.py validation/test_sprung_vibration.py",
    "parametric": "unit/parametric maps/test_parameter_units.py",
    "files": "unit/files maps/test_parameter_units.py",
}

#: What all folders of mechanics are tested by, too.
_GENERAL = "validation/test_closed_forms.py properties/test_loop_statics.py properties/test_properties.py"
for _place in ("math", "mechanism", "kinematics", "elements", "limbs", "statics", "results"):
    TESTS[_place] += f" {_GENERAL}"

_SWAPPED = {"Add": "-", "Sub": "+", "Mult": "/", "Div": "*", "FloorDiv": "*", "Mod": "*"}
_SIGNS = {"Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "FloorDiv": "//", "Mod": "%"}
_OPPOSITE = {"Lt": ">=", "LtE": ">", "Gt": "<=", "GtE": "<", "Eq": "!=", "NotEq": "==", "In": "not in", "NotIn": "in"}
_BOUNDS = ("max", "min", "np.maximum", "np.minimum", "np.clip")

#: Kind, start and end of the bytes that are replaced, and the new text.
Change = tuple[str, int, int, str]


@dataclass(frozen=True)
class Mutant:
    """One mistake: its module, line and kind, what stood there and what stands there now; the bytes put in place of others."""

    module: str
    line: int
    kind: str
    was: str
    now: str
    change: tuple[int, int, str]

    @property
    def name(self) -> str:
        return f"{self.module}: {self.was.strip()} -> {self.now.strip()}"

    @property
    def text(self) -> str:
        """The mutated module."""
        start, end, new = self.change
        raw = (PACKAGE / f"{self.module}.py").read_bytes()
        return (raw[:start] + new.encode() + raw[end:]).decode()


# ---- making mistakes ---------------------------------------------------------------------------------------------------


def mutants(module: str) -> Iterator[Mutant]:
    raw = (PACKAGE / f"{module}.py").read_bytes()
    lines = raw.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(line: int, column: int) -> int:
        return starts[line - 1] + column

    for kind, start, end, new in _changes(ast.parse(raw), place, raw):
        number = raw[:start].count(b"\n")
        rest = raw[end : raw.find(b"\n", end)].decode()
        was, now = lines[number].decode().rstrip(), raw[starts[number] : start].decode() + new + rest
        yield Mutant(module, number + 1, kind, was, now.splitlines()[0], (start, end, new))


def _changes(tree: ast.Module, place, raw: bytes) -> Iterator[Change]:
    def span(node: ast.expr | ast.stmt) -> tuple[int, int]:
        return place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)

    def text(node: ast.expr) -> str:
        start, end = span(node)
        return raw[start:end].decode()

    skipped = {id(part) for node in ast.walk(tree) for part in _without_numbers(node)}
    for node in _walk(tree, skipped):
        if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.BitAnd, ast.BitOr)) and not _is_type(node):
            for part in (node.left, node.right):
                yield "guard", *span(node), f"({text(part)})"
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in _BOUNDS and len(node.args) > 1:
            for part in node.args[: 1 if ast.unparse(node.func) == "np.clip" else 2]:
                if not isinstance(part, ast.Starred):
                    yield "guard", *span(node), f"({text(part)})"
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "np.where" and len(node.args) == 3:
            mask, *parts = map(text, node.args)
            for part in parts:
                yield "guard", *span(node), f"np.where({mask}, {part}, {part})"
        elif isinstance(node, (ast.BinOp, ast.Compare, ast.BoolOp)):
            yield from _operators(node, place, raw)
        elif isinstance(node, ast.AugAssign) and type(node.op).__name__ in _SWAPPED:
            name = type(node.op).__name__
            between = _between(node.target, node.value, place)
            at = raw.index(f"{_SIGNS[name]}=".encode(), between[0], between[1])
            yield "arithmetic", at, at + len(_SIGNS[name]), _SWAPPED[name]
        elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
            kind, new = {"Not": ("condition", ""), "Invert": ("guard", ""), "USub": ("arithmetic", "+")}[type(node.op).__name__]
            start = span(node)[0]
            yield kind, start, start + (3 if isinstance(node.op, ast.Not) else 1), new
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            kind = "tolerance" if 0 < node.value < 1e-3 else "arithmetic"
            for new in _numbers(node.value):
                yield kind, *span(node), new
        elif isinstance(node, (ast.If, ast.IfExp, ast.While)):
            yield "condition", *span(node.test), f"(not ({text(node.test)}))"
        if isinstance(node, ast.BoolOp):
            for part in node.values:
                yield "condition", *span(part), str(isinstance(node.op, ast.And))
        if isinstance(node, ast.AugAssign) or (
            isinstance(node, ast.Assign) and all(isinstance(target, ast.Subscript) for target in node.targets)
        ):
            yield "arithmetic", *span(node), "pass"


def _is_type(node: ast.expr) -> bool:
    """Whether an expression is a union of types, such as ``int | None``."""
    if isinstance(node, ast.BinOp):
        return _is_type(node.left) or _is_type(node.right)
    name = node.value if isinstance(node, ast.Constant) else node.id if isinstance(node, ast.Name) else ""
    return name is None or (
        isinstance(name, str) and (name[:1].isupper() or name in ("int", "float", "bool", "str", "dict", "list"))
    )


def _operators(node: ast.BinOp | ast.Compare | ast.BoolOp, place, raw: bytes) -> Iterator[Change]:
    if isinstance(node, ast.BoolOp):
        word, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        start, end = _between(node.values[0], node.values[1], place)
        at = raw.index(word.encode(), start, end)
        yield "condition", at, at + len(word), other
        return
    left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.left, node.comparators[0])
    name = type(node.op if isinstance(node, ast.BinOp) else node.ops[0]).__name__
    start, end = _between(left, right, place)
    if isinstance(node, ast.BinOp) and name in _SWAPPED:
        at = raw.index(_SIGNS[name].encode(), start, end)
        yield "arithmetic", at, at + len(_SIGNS[name]), _SWAPPED[name]
    elif name in _OPPOSITE:
        sign = re.compile(rb"not\s+in|in|[<>=!]=|[<>]").search(raw, start, end)
        yield "condition", *sign.span(), _OPPOSITE[name]


def _between(left: ast.expr, right: ast.expr, place) -> tuple[int, int]:
    return place(left.end_lineno, left.end_col_offset), place(right.lineno, right.col_offset)


def _numbers(value: float) -> list[str]:
    if isinstance(value, float) and 0 < value < 1e-200:  # only there to keep a division from one by zero
        return []
    if isinstance(value, float) and 0 < value < 1e-3:
        return [repr(value * 1e3), repr(value / 1e3)]
    return [repr(2 * value)] if isinstance(value, float) and value else [repr(value + 1)]


def _walk(node: ast.AST, skipped: set[int]) -> Iterator[ast.AST]:
    if id(node) not in skipped:
        yield node
        for child in ast.iter_child_nodes(node):
            yield from _walk(child, skipped)


def _without_numbers(node: ast.AST) -> list[ast.AST]:
    """Return the parts of a node in which no mistake is made: annotations, decorators, messages, what only types need."""
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        return [*node.decorator_list, *([node.returns] if node.returns else [])]
    if isinstance(node, ast.arg) and node.annotation:
        return [node.annotation]
    if isinstance(node, ast.AnnAssign):
        return [node.annotation]
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return [node]
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
        return [part for part in node.args if ast.unparse(part) == "-1"]  # any negative length is the one that fits
    return [node] if isinstance(node, (ast.JoinedStr, ast.Raise, ast.Assert)) else []


# ---- which test reaches which line ---------------------------------------------------------------------------------------


class _Recorder:
    """Tells coverage which test runs, and notes how much of the processor's time each takes and which do not pass."""

    def __init__(self, coverage) -> None:
        self.coverage, self.seconds, self.left_out, self.before = coverage, Counter(), set(), 0.0

    def pytest_runtest_logstart(self, nodeid: str, location) -> None:
        self.coverage.switch_context(nodeid.partition("[")[0])
        self.before = sum(os.times()[:4])

    def pytest_runtest_logreport(self, report) -> None:
        test = report.nodeid.partition("[")[0]
        if report.when == "teardown":
            self.seconds[test] += sum(os.times()[:4]) - self.before
        if report.failed:
            self.left_out.add(test)


def test_map(places: Iterable[str]) -> dict:
    """Return the seconds of each test about some folders, and which tests reach each line; the files of tests run if need be."""
    paths = [ROOT / "tests" / name for place in places for name in TESTS[place.partition("/")[0]].split()]
    files = sorted({file for path in paths for file in (path.rglob("test_*.py") if path.is_dir() else [path])})
    shared = [
        Path(__file__),
        *sorted(PACKAGE.rglob("*.py")),
        *sorted((ROOT / "tests" / "support").glob("*.py")),
        ROOT / "tests" / "conftest.py",
    ]
    version = b"".join(path.read_bytes() for path in shared)
    known: dict = {"seconds": {}, "lines": {}}
    for file in files:
        key = hashlib.sha256(version + file.read_bytes()).hexdigest()
        kept = MAPS / f"{'_'.join(file.relative_to(ROOT / 'tests').with_suffix('').parts)}.json"
        part = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {"key": None}
        if part["key"] != key:
            part = {"key": key, **_lines_of_tests(file)}
            MAPS.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(part), encoding="utf-8")
        if part["left_out"]:
            print("do not pass without mutants, left out:", *part["left_out"], flush=True)
        known["seconds"] |= part["seconds"]
        for module, lines in part["lines"].items():
            for line, tests in lines.items():
                known["lines"].setdefault(module, {}).setdefault(line, []).extend(tests)
    return known


def _lines_of_tests(file: Path) -> dict:
    """Run a file of tests in a copy of the package: seconds of each test that passes, and which tests reach each line."""
    with tempfile.TemporaryDirectory() as folder:
        copy, result = _copy(folder), Path(folder) / "result.json"

        def measured() -> int:
            import coverage

            measuring = coverage.Coverage(data_file=None, source=[str(copy)], config_file=False)
            recorder = _Recorder(measuring)
            measuring.start()
            code = pytest.main(["-q", "-p", "no:cacheprovider", str(file.relative_to(ROOT))], plugins=[recorder])
            measuring.stop()
            data = measuring.get_data()
            lines = {}
            for path in data.measured_files():
                reached = data.contexts_by_lineno(path)
                lines[Path(path).relative_to(copy).with_suffix("").as_posix()] = {
                    line: sorted(set(tests) - recorder.left_out - {""}) for line, tests in reached.items()
                }
            seconds = {test: time for test, time in recorder.seconds.items() if test not in recorder.left_out}
            result.write_text(json.dumps({"seconds": seconds, "left_out": sorted(recorder.left_out), "lines": lines}))
            return int(code)

        code = _in_a_process(folder, measured, 3600)
        if code not in (0, 1, 5) or not result.exists():  # 5: all tests of the file are slow
            sys.exit(f"{file}: pytest ends with exit code {code} without mutants")
        return json.loads(result.read_text(encoding="utf-8"))


def tests_of(mutant: Mutant, known: dict) -> list[str]:
    """Return the tests that reach a mutant, in the order to try them; for a constant those that reach a line that uses it."""
    lines = known["lines"].get(mutant.module, {})
    at_line = set(lines.get(str(mutant.line), ()))
    found = set(at_line)
    names: set[str] = set()
    mine = re.compile(rf"/test_(\w+_)?{mutant.module.rpartition('/')[2]}\.py::")
    for node in ast.walk(ast.parse(mutant.text)):
        if isinstance(node, ast.FunctionDef) and node.lineno <= mutant.line <= node.end_lineno:
            # its head has defaults; and of a line that has changed since the map knows but what reaches the rest
            found |= {test for line in range(node.body[0].lineno, node.end_lineno + 1) for test in lines.get(str(line), ())}
    for node in ast.parse(mutant.text).body:  # what is read once, when the module is: by the test that comes first
        if node.lineno <= mutant.line <= node.end_lineno:
            names |= _constants(node, mutant.line)
    if names:
        found |= {test for test in known["seconds"] if mine.search(test)}
    for name in names:
        found |= _tests_of_name(name, known, set(names))
    found.discard("")
    if not found:  # what runs in processes of its own: by tests of the same folder
        beside = mutant.module.rpartition("/")[0] + "/"
        found = {
            test for name, reached in known["lines"].items() if name.startswith(beside) for t in reached.values() for test in t
        }
    # those of the module itself, then those that reach the very line; of them the quickest of every file, then the second
    # quickest: files have subjects of their own
    files: dict[str, list[str]] = {}
    for test in sorted(found, key=lambda test: known["seconds"].get(test, 0.0)):
        files.setdefault(test.partition("::")[0], []).append(test)
    mixed = [test for row in zip_longest(*files.values()) for test in row if test]
    return sorted(mixed, key=lambda test: (not mine.search(test), test not in at_line))


def _constants(node: ast.stmt, line: int) -> set[str]:
    """Return the names that a statement of a module gives something made in a line: constants, or a class for its fields."""
    if isinstance(node, ast.ClassDef):
        inside = any(isinstance(part, ast.FunctionDef) and part.lineno <= line <= part.end_lineno for part in node.body)
        return set() if inside else {node.name}
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}
    return set()


def _tests_of_name(name: str, known: dict, seen: set[str]) -> set[str]:
    """Return the tests that reach a line with a name in it, or with the name of a constant made of it."""
    found: set[str] = set()
    for path in PACKAGE.glob("**/*.py"):
        lines = known["lines"].get(str(path.relative_to(PACKAGE).with_suffix("")), {})
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if re.search(rf"\b{name}\b", line):
                found |= set(lines.get(str(number), ()))
                constant = re.match(r"(\w+)(: [^=]+)? = ", line)
                if constant and constant[1] not in seen:
                    found |= _tests_of_name(constant[1], known, seen | {constant[1]})
    return found


# ---- trying them -----------------------------------------------------------------------------------------------------------


def outcome(mutant: Mutant, tests: list[str], seconds: float, known: dict) -> str:
    """Return what the tests that fit into so many seconds make of a mutant: killed, survived, timeout, or broken."""
    chosen, total = [], 0.0
    for test in tests:
        needed = known["seconds"].get(test, 0.0)
        if not chosen or total + needed <= seconds:
            chosen.append(test)
            total += needed
    if not chosen:
        return "survived"
    with tempfile.TemporaryDirectory() as folder:
        module = _copy(folder) / f"{mutant.module}.py"
        module.unlink()  # the copy consists of links
        module.write_text(mutant.text, encoding="utf-8")
        code = _in_a_process(
            folder, lambda: pytest.main(["-x", "-q", "-p", "no:cacheprovider", *chosen]), 30 + 6 * round(min(total, seconds))
        )
    return {0: "survived", 1: "killed", -signal.SIGXCPU: "timeout", -signal.SIGALRM: "timeout"}.get(code, "broken")


def _copy(folder: str) -> Path:
    """Copy the project, with compiled files, as links, and return where the package lies."""
    for path in ROOT.iterdir():
        if path.is_dir() and path.name not in ("build", ".git", ".venv", "site", ".hypothesis", ".mypy_cache", ".ruff_cache"):
            shutil.copytree(path, Path(folder) / path.name, copy_function=os.link)
        elif path.is_file():
            os.link(path, Path(folder) / path.name)
    return Path(folder) / "src" / "kinetostatics"


def _in_a_process(folder: str, run, seconds: int) -> int:
    """Run a function in a process with the project as it lies in a folder, for so many seconds at most; return its exit code."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    signal.alarm(10 * seconds)  # what waits uses no time of the processor
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    os.environ["PYTHONPATH"] = f"{folder}/src"
    os.environ["CI"] = "true"  # the same examples every time
    os.environ["KINETOSTATICS_CACHE"] = f"{folder}/code"  # which mutants make, too
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # which takes longer than most tests
    sys.path.insert(0, f"{folder}/src")
    os.chdir(folder)
    code = 3
    try:
        code = run()
    finally:
        os._exit(int(code))


def _drawn(place: str, count: int, seed: int, excused: set[str]) -> list[Mutant]:
    """Draw mutants of a folder or module, of each kind equally many as far as there are so many."""
    every = [mutant for module in _modules(place) for mutant in mutants(module)]
    gone = excused - {mutant.name for mutant in every}
    for name in sorted(name for name in gone if name.partition(": ")[0] in _modules(place)):
        print(f"excused, but not there any more: {name}", flush=True)
    chance = random.Random(f"{seed} {place}")
    kinds = []
    for kind in KINDS:
        possible = [mutant for mutant in every if mutant.kind == kind and mutant.name not in excused]
        kinds.append(chance.sample(possible, min(count, len(possible))))
    return [mutant for row in zip_longest(*kinds) for mutant in row if mutant][:count]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("places", nargs="*", default=list(TESTS), help="folders or modules of the package; default: all of TESTS")
    parser.add_argument("--count", type=int, default=15, help="mutants of each folder or module")
    parser.add_argument("--seed", type=int, default=0, help="which ones are drawn")
    parser.add_argument("--seconds", type=float, default=20.0, help="of tests that each mutant meets at most")
    parser.add_argument("--jobs", type=int, default=1, help="how many are tried at a time")
    options = parser.parse_args()
    for name in ("hypothesis", "pinocchio", "xarray", "scipy.optimize"):
        importlib.import_module(name)  # once, before the first fork
    compileall.compile_dir(PACKAGE, quiet=1)
    excused = {line.rpartition("  # ")[0].strip() for line in WITHOUT_EFFECT.read_text(encoding="utf-8").splitlines()}
    counts: dict[str, Counter[str]] = {}
    for place in options.places:
        known, found = test_map([place]), Counter()

        def judge(mutant: Mutant, known: dict = known, found: Counter[str] = found) -> None:
            tests = tests_of(mutant, known)
            result = outcome(mutant, tests, options.seconds, known)
            found[result] += 1
            found[result, mutant.kind] += 1
            if result != "killed":
                print(f"{result} ({mutant.kind}, {len(tests)} tests reach it): {mutant.module}.py:{mutant.line}")
                print(f"    {mutant.was.strip()}\n    {mutant.now.strip()}", flush=True)

        with ThreadPoolExecutor(options.jobs) as pool:
            list(pool.map(judge, _drawn(place, options.count, options.seed, excused)))
        counts[place] = found
        print(_line(place, found), flush=True)
    print(_line("all", sum(counts.values(), Counter())))
    for kind in KINDS:
        print(_line(kind, Counter({result: sum(found[result, kind] for found in counts.values()) for result in _RESULTS})))
    return 0


_RESULTS = ("killed", "survived", "timeout", "broken")


def _line(name: str, found: Counter) -> str:
    tried = found["killed"] + found["survived"]
    share = f"{100 * found['killed'] / tried:.0f} %" if tried else "-"
    return f"{name:28} killed {found['killed']:3} of {tried:3}, {share}; timeouts {found['timeout']}, broken {found['broken']}"


def _modules(place: str) -> list[str]:
    """Return the modules of a folder, or the one of that name."""
    if not (PACKAGE / place).is_dir():
        return [place]
    return [str(path.relative_to(PACKAGE).with_suffix("")) for path in sorted((PACKAGE / place).rglob("*.py"))]


if __name__ == "__main__":
    sys.exit(main())
