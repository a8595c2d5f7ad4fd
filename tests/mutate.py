"""Small mistakes, put into the numeric code one at a time: which of them do the tests notice?

    python tests/mutate.py                       # a sample from every folder that computes numbers
    python tests/mutate.py engine statics/solution           # from this folder and this module
    python tests/mutate.py statics/solution --count 40 --seed 3 --jobs 2
    python tests/mutate.py --map                 # find out again which test reaches which line: over an hour
    python tests/mutate.py --map test_screws     # the same for some files of tests, say new ones

Each mistake (a mutant) changes one thing: an operator, a comparison, a sign, a number, a statement left out. Thresholds, the
numbers below 1e-3, become a thousand times larger and smaller. Every mutant meets the tests that reach its line, the quickest
first, until one fails. What no test notices is listed; mutants that change nothing a user could see are named with the reason in
``mutants_without_effect.txt`` (``-> …``: all of a line) and do not count. Needs ``coverage`` (in the extra ``test``) and a
system that can fork.

Which test reaches which line is kept in ``build``; lines that have moved since are found by their text.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import difflib
import importlib
import json
import os
import random
import re
import resource
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "src" / "kinetostatics"
MAP = ROOT / "build" / "tests_of_lines.json"
WITHOUT_EFFECT = Path(__file__).parent / "mutants_without_effect.txt"

#: The folders in which a mistake makes a wrong number, and the modules beside them.
FOLDERS = """math sections description mechanism kinematics limbs statics buckling engine functions results checks
indices workspace calibration design verification""".split()
MODULES = ["analysis", "compensation", "robot", "status", "layout/numbers"]

#: Tests that reach the core by way of a browser, other processes or large maps tell little about single numbers for their time.
SLOW = re.compile(
    r"test_(viewer|plot|fuzz|solid|workspace_figures|benchmarks|guide|readme|examples|cli|foreign|robot_files|python_api"
    r"|random|rewritings|mutate)"
)

_SWAPPED = {"Add": "-", "Sub": "+", "Mult": "/", "Div": "*", "FloorDiv": "*", "Mod": "*"}
_SIGNS = {"Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "FloorDiv": "//", "Mod": "%"}
_OPPOSITE = {"Lt": ">=", "LtE": ">", "Gt": "<=", "GtE": "<", "Eq": "!=", "NotEq": "==", "In": "not in", "NotIn": "in"}


@dataclass(frozen=True)
class Mutant:
    """One mistake: in which module and line, what stood there and what stands there now; the bytes put in place of others."""

    module: str
    line: int
    was: str
    now: str
    change: tuple[int, int, str]

    @property
    def name(self) -> str:
        return f"{self.module}: {self.was.strip()} -> {self.now.strip()}"

    @property
    def line_name(self) -> str:
        """How all mutants of the line are excused together."""
        return f"{self.module}: {self.was.strip()} -> …"

    @property
    def text(self) -> str:
        """The mutated module."""
        start, end, new = self.change
        raw = (PACKAGE / f"{self.module}.py").read_bytes()
        return (raw[:start] + new.encode() + raw[end:]).decode()


# ---- making mistakes ---------------------------------------------------------------------------------------------------


def mutants(module: str) -> Iterator[Mutant]:
    """Yield every mutant of a module."""
    raw = (PACKAGE / f"{module}.py").read_bytes()
    lines = raw.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(line: int, column: int) -> int:
        return starts[line - 1] + column

    for start, end, new in _changes(ast.parse(raw), place, raw):
        number = raw[:start].count(b"\n")
        rest = raw[end : raw.find(b"\n", end)].decode()
        was, now = lines[number].decode().rstrip(), raw[starts[number] : start].decode() + new + rest
        yield Mutant(module, number + 1, was, now.splitlines()[0], (start, end, new))


def _changes(tree: ast.Module, place, raw: bytes) -> Iterator[tuple[int, int, str]]:
    """Yield (start, end, new text) of every change."""
    skipped = {id(part) for node in ast.walk(tree) for part in _without_numbers(node)}
    for node in _walk(tree, skipped):
        span = (
            (place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset))
            if hasattr(node, "lineno")
            else None
        )
        if isinstance(node, (ast.BinOp, ast.Compare, ast.BoolOp)):
            yield from _operators(node, place, raw)
        elif isinstance(node, ast.AugAssign) and type(node.op).__name__ in _SWAPPED:
            name = type(node.op).__name__
            between = _between(node.target, node.value, place)
            at = raw.index(f"{_SIGNS[name]}=".encode(), between[0], between[1])
            yield at, at + len(_SIGNS[name]), _SWAPPED[name]
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            yield (span[0], span[0] + 3, "") if isinstance(node.op, ast.Not) else (span[0], span[0] + 1, "+")
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            for new in _numbers(node.value):
                yield *span, new
        elif isinstance(node, (ast.If, ast.IfExp, ast.While)):
            test = node.test
            start, end = place(test.lineno, test.col_offset), place(test.end_lineno, test.end_col_offset)
            yield start, end, f"(not ({raw[start:end].decode()}))"
        if isinstance(node, ast.AugAssign) or (
            isinstance(node, ast.Assign) and all(isinstance(target, ast.Subscript) for target in node.targets)
        ):
            yield *span, "pass"


def _operators(node: ast.BinOp | ast.Compare | ast.BoolOp, place, raw: bytes) -> Iterator[tuple[int, int, str]]:
    if isinstance(node, ast.BoolOp):
        word, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        start, end = _between(node.values[0], node.values[1], place)
        at = raw.index(word.encode(), start, end)
        yield at, at + len(word), other
        return
    left, right = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.left, node.comparators[0])
    name = type(node.op if isinstance(node, ast.BinOp) else node.ops[0]).__name__
    start, end = _between(left, right, place)
    if isinstance(node, ast.BinOp) and name in _SWAPPED:
        at = raw.index(_SIGNS[name].encode(), start, end)
        yield at, at + len(_SIGNS[name]), _SWAPPED[name]
    elif name in _OPPOSITE:
        found = re.compile(rb"not\s+in|in|[<>=!]=|[<>]").search(raw, start, end)
        yield *found.span(), _OPPOSITE[name]


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
    """Tells coverage which test runs, and notes how long each takes and which fail."""

    def __init__(self, coverage) -> None:
        self.coverage, self.seconds, self.failed = coverage, Counter(), set()

    def pytest_runtest_logstart(self, nodeid: str, location) -> None:
        self.coverage.switch_context(nodeid.partition("[")[0])

    def pytest_runtest_logreport(self, report) -> None:
        test = report.nodeid.partition("[")[0]
        self.seconds[test] += report.duration
        if report.failed:
            self.failed.add(test)


def make_map(names: list[str]) -> None:
    """Run the tests of some files, each in a process of its own, and write down which of them reach which line."""
    files = [path for path in sorted((ROOT / "tests").rglob("test_*.py")) if path.stem in names]
    part = MAP.with_suffix(".part")
    MAP.parent.mkdir(exist_ok=True)
    for file in files:
        if (child := os.fork()) == 0:
            os.chdir(ROOT)
            os.environ["CI"] = "true"  # the same examples every time
            part.write_text(json.dumps(_lines_of_tests(file)), encoding="utf-8")
            os._exit(0)
        if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0:
            _write_map(f"{file.relative_to(ROOT).as_posix()}::", json.loads(part.read_text(encoding="utf-8")))
    part.unlink(missing_ok=True)


def _lines_of_tests(file: Path) -> dict:
    """Return the seconds of each test of a file, and for each line that is reached, which tests do so."""
    import coverage

    measured = coverage.Coverage(data_file=None, source=[str(PACKAGE)], config_file=False)
    recorder = _Recorder(measured)
    measured.start()
    pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:xdist", str(file)], plugins=[recorder])
    measured.stop()
    found = measured.get_data()
    lines: dict = {}
    for path in found.measured_files():
        reached = found.contexts_by_lineno(path)
        lines[str(Path(path).relative_to(PACKAGE).with_suffix(""))] = {
            line: sorted(test for test in tests if test and test not in recorder.failed) for line, tests in reached.items()
        }
    if recorder.failed:
        print("fail as they are and are left out:", *sorted(recorder.failed), flush=True)
    return {"seconds": recorder.seconds, "lines": lines}


def _write_map(prefix: str, new: dict) -> None:
    """Put the tests of one file into the map, in place of what it knew of them."""
    known = read_map() if MAP.exists() else {"seconds": {}, "lines": {}}
    seconds = {test: time for test, time in known["seconds"].items() if not test.startswith(prefix)}
    lines: dict = {}
    for module, reached in known["lines"].items():
        lines[module] = {line: [t for t in tests if not t.startswith(prefix)] for line, tests in reached.items()}
    for module, reached in new["lines"].items():
        for line, tests in reached.items():
            lines.setdefault(module, {}).setdefault(line, []).extend(tests)
    texts = {module: (PACKAGE / f"{module}.py").read_text(encoding="utf-8") for module in lines}
    MAP.write_text(json.dumps({"seconds": {**seconds, **new["seconds"]}, "lines": lines, "texts": texts}), encoding="utf-8")


def read_map() -> dict:
    """Return the map, its lines numbered as they are now."""
    known = json.loads(MAP.read_text(encoding="utf-8"))
    for module in list(known["lines"]):
        path = PACKAGE / f"{module}.py"
        if not path.exists():
            del known["lines"][module]
            continue
        then, now = known["texts"][module].splitlines(), path.read_text(encoding="utf-8").splitlines()
        if then != now:
            moved = {}
            for old, new, count in difflib.SequenceMatcher(None, then, now, autojunk=False).get_matching_blocks():
                moved |= {str(old + k + 1): str(new + k + 1) for k in range(count)}
            reached = known["lines"][module]
            known["lines"][module] = {moved[line]: tests for line, tests in reached.items() if line in moved}
    return known


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


def survives(mutant: Mutant, tests: list[str], seconds: float, known: dict) -> bool:
    """Whether the tests that fit into so many seconds all pass with the mutant."""
    chosen, total = [], 0.0
    for test in tests:
        needed = known["seconds"].get(test, 0.0)
        if not chosen or total + needed <= seconds:
            chosen.append(test)
            total += needed
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "src" / "kinetostatics"
        shutil.copytree(PACKAGE, copy)  # compiled files, too
        (Path(folder) / "robots").symlink_to(ROOT / "robots")
        (copy / f"{mutant.module}.py").write_text(mutant.text, encoding="utf-8")
        child = os.fork()
        if not child:
            _try(folder, chosen, 30 + 6 * round(min(total, seconds)))
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def _try(folder: str, tests: list[str], seconds: int) -> None:
    """In a process of its own, which may take so many seconds: run tests with the package as it lies in a folder, and leave."""
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    os.environ["PYTHONPATH"] = f"{folder}/src"
    os.environ["CI"] = "true"  # the same examples every time
    os.environ["KINETOSTATICS_CACHE"] = f"{folder}/code"  # which mutants make, too
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # which takes longer than most tests
    sys.path.insert(0, f"{folder}/src")
    os.chdir(ROOT)
    code = 1
    try:
        code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests])
    finally:
        os._exit(int(code))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "places", nargs="*", help="folders or modules of the package (with --map: files of tests); default: what makes numbers"
    )
    parser.add_argument("--count", type=int, default=20, help="mutants of each folder or module")
    parser.add_argument("--seed", type=int, default=0, help="which ones are drawn")
    parser.add_argument("--seconds", type=float, default=40.0, help="of tests that each mutant meets at most")
    parser.add_argument("--jobs", type=int, default=1, help="how many are tried at a time")
    parser.add_argument("--map", action="store_true", help="find out which test reaches which line, nothing else")
    options = parser.parse_args()
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    every = [path.stem for path in sorted((ROOT / "tests").rglob("test_*.py")) if not SLOW.match(path.name)]
    if options.map or not MAP.exists():
        make_map(options.places or every)
    if options.map:
        return 0
    places = options.places or [*FOLDERS, *MODULES]
    known = read_map()
    excused = {line.rpartition("  # ")[0].strip() for line in _excuses()}
    drawn: list[Mutant] = []
    counts: dict[str, Counter[str]] = {place: Counter() for place in places}
    place_of: dict[str, str] = {}
    for place in places:
        possible = []
        for module in _modules(place):
            place_of[module] = place
            every_one = list(mutants(module))
            possible += [mutant for mutant in every_one if not {mutant.name, mutant.line_name} & excused]
            names = {name for mutant in every_one for name in (mutant.name, mutant.line_name)}
            for name in sorted(excused - names):
                if name.startswith(f"{module}: "):
                    print(f"excused, but not there any more: {name}", flush=True)
        drawn += random.Random(f"{options.seed} {place}").sample(possible, min(options.count, len(possible)))
    random.Random(options.seed).shuffle(drawn)  # so that a part of them is a fair sample, too

    def judge(mutant: Mutant) -> None:
        tests = tests_of(mutant, known)
        outcome = "survived" if not tests or survives(mutant, tests, options.seconds, known) else "noticed"
        counts[place_of[mutant.module]][outcome] += 1
        print("." if outcome == "noticed" else "S", end="", file=sys.stderr, flush=True)
        if outcome == "survived":
            reached = f"{len(tests)} tests reach it" if tests else "no test reaches it"
            print(
                f"not noticed ({reached}): {mutant.module}.py:{mutant.line}\n    {mutant.was.strip()}\n    {mutant.now.strip()}",
                flush=True,
            )

    for name in ("hypothesis", "pinocchio", "xarray", "scipy.optimize"):
        importlib.import_module(name)  # once, before the first fork
    compileall.compile_dir(PACKAGE, quiet=1)

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(judge, drawn))
    for place, found in counts.items():
        print(f"{place:28} {found['noticed']:4} of {found.total():4} noticed")
    noticed, total = sum(found["noticed"] for found in counts.values()), len(drawn)
    print(f"{noticed} of {total} mutants noticed: {100 * noticed / max(total, 1):.1f} %")
    return 0


def _modules(place: str) -> list[str]:
    """Return the modules of a folder, or the one of that name."""
    if not (PACKAGE / place).is_dir():
        return [place]
    return [str(path.relative_to(PACKAGE).with_suffix("")) for path in sorted((PACKAGE / place).rglob("*.py"))]


def _excuses() -> list[str]:
    return WITHOUT_EFFECT.read_text(encoding="utf-8").splitlines() if WITHOUT_EFFECT.exists() else []


if __name__ == "__main__":
    sys.exit(main())
