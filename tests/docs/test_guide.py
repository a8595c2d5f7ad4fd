"""The guide: every block is run and every answer compared, and every error of the code is in the tables of messages.

Where an answer or a message has changed, ``python tests/support/guide_pages.py`` writes the pages anew; look at the difference.
An error that is new in the code needs a mistake that provokes it in one of ``guide_mistakes_of_*.py``.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from guide_mistakes import ROOT, SOURCE, Mistake, provoke, sites
from guide_pages import GUIDE, MESSAGES, STORIES, TABLES, answers, blocks, marked, table

import kinetostatics as ks
from kinetostatics.checks.collect import robot_facts

ROBOT = ROOT / "examples" / "guide_robot" / GUIDE.file

#: Folders whose errors are not about robots, or have pages of their own. Those of the engine are reasons in its report.
ELSEWHERE = {
    *("cli", "design", "engine", "files/importers", "functions", "indices"),
    *("plots", "report_page", "verification", "viewer", "workspace"),
}


def modules() -> list[str]:
    """Return the modules whose messages stand in the guide, by their paths in the package."""
    every = sorted(path.relative_to(SOURCE).as_posix() for path in SOURCE.rglob("*.py"))
    return [name for name in every if not any(name.startswith(f"{folder}/") for folder in ELSEWHERE) and name[:2] != "__"]


#: Errors that no robot file and no argument leads to, by words of theirs.
UNREACHABLE = {
    "moves joints of a closed chain that hangs on base or platform": "needs such a chain, see test_mimic.py",
    "is rigid and cannot carry a beam; give the beam": "the reader refuses such a beam before, with its own message",
    "has a density, which replaces the link's <inertial>; give this": "the reader refuses such beams before",
    "Pinocchio cannot read the URDF part of the file:": "the reader checks all that Pinocchio refuses",
    "no complementary wrench number": "six seeds always span what is missing",
    "contradict one another in rigid parts": "the table is rigid nowhere; test_random_hybrids.py has a robot that is",
    "has no anchor constraints": "Pinocchio's version decides",
    "lies within the rigid base or platform": "the table has no weld there; test_random_hybrids.py has",
    "has no actuators, so that nothing can be corrected": "the table has an actuator; see test_compensate.py",
    "no coordinates with the orientation": "needs a robot that no coordinates of the platform tell",
    "no actuator positions were found that bring": "the table has no pose at its rim; see test_compensate.py",
    "cannot be written: there is no folder": "the table writes no files; see test_compensate.py",
    "the sag changes too much from pose to pose": "needs a robot so soft that no correction converges",
    "a Dataset needs xarray": "tests have it",
    "nothing is registered that writes a": "all that is printed has its report",
    "readings cannot be computed": "the analysis says why; the table has that",
    "needs SciPy: pip install": "tests have it",
    ", which has no statics: make one": "the poses that people are given belong to a Robot",
}
#: Warnings likewise.
WARNINGS_UNREACHABLE = {
    "no limb joins base and platform": "see test_check_explains_robots_without_limbs",
    "the mobility is doubtful": "needs a robot that is almost singular in every pose",
    "the number of constraint wrenches of": "needs a limb that is almost singular in every pose",
    "as much under such a load as near the zero pose": "needs a network that nearly collapses, see test_careful_warnings.py",
    "no pose could be analysed": "needs loops that close nowhere that was tried, although they can",
    "the canonical wrenches of": "needs limbs with more than rods, as those in test_degenerate_poses.py",
    "the rigid rings in": "needs a rigid ring in a limb, see test_hybrid_limbs.py",
}


@cache
def provoked() -> dict[str, list[tuple[Mistake, list[str], set[tuple[str, int]]]]]:
    """Make all mistakes once, some two hundred, which takes several seconds."""
    result: dict[str, list[tuple[Mistake, list[str], set[tuple[str, int]]]]] = {}
    for name, mistakes in TABLES.items():
        result[name] = []
        for mistake in mistakes:
            with TemporaryDirectory() as folder:
                result[name].append((mistake, *provoke(mistake, Path(folder))))
    return result


# ---- the story ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=STORIES, ids=lambda story: story.pages[0].stem)
def story(request, tmp_path_factory):
    """Some pages, what their blocks answer, and the file in the end."""
    return request.param, *answers(request.param, tmp_path_factory.mktemp("guide"))


def steady(text: str) -> str:
    """Return a text in which directions, which may point either way, point one way."""

    def turned(found: re.Match[str]) -> str:
        numbers = [part.strip() for part in found[2].split(",")]
        if next((part for part in numbers if float(part)), "").startswith("-"):
            numbers = [part if not float(part) else part[1:] if part[0] == "-" else f"-{part}" for part in numbers]
        return f"{found[1]} ({', '.join(numbers)})"

    return re.sub(r"\b(along|axis)\s+\(([-\d., ]+)\)", turned, text)


def words(text: str) -> list[str | float]:
    """Return numbers, with those that are only rounding as zeros, and all else; left and right may come in either order."""
    found: list[str | float] = []
    for word in steady(text.replace("right_", "left_")).split():
        number = re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]\d+)?", word)
        found.append((0.0 if abs(float(word)) < 1e-9 else float(word)) if number else word)
    return found


@pytest.mark.few(2)
def test_every_answer_of_the_page_is_what_is_printed(story):
    pages, found, _ = story
    everything = [item for page in found for item in page]
    assert pages is not GUIDE or len(everything) > 15
    for block, answer in everything:
        shown, printed = words(block.text), words(answer)
        assert len(shown) == len(printed), f"stale:\n{block.text}\nnow:\n{answer}"
        for a, b in zip(shown, printed, strict=True):
            same = a == pytest.approx(b, rel=1e-3) if isinstance(a, float) and isinstance(b, float) else a == b
            assert same, f"{a} in the page, {b} printed; stale:\n{block.text}\nnow:\n{answer}"


def test_blocks_of_every_kind_are_run():
    texts = GUIDE.texts()
    found = [block for text in texts for block in blocks(text)]
    assert {block.kind for block in found} == {"xml", "console", "python", "text"}
    assert sum(text.count("```") for text in texts) == 2 * len(found)
    assert all(block.mark.startswith("lift") for block in found if block.kind == "xml")


@pytest.mark.few(2)
def test_the_robot_in_the_examples_is_the_one_of_the_guide(story):
    pages, _, file = story
    assert pages is not GUIDE or ROBOT.read_text(encoding="utf-8") == file


def test_the_sketches_are_those_that_the_script_draws():
    sys.path.insert(0, str(ROBOT.parent))
    try:
        from draw_sketches import SKETCHES
    finally:
        sys.path.remove(str(ROBOT.parent))
    for name, draw in SKETCHES.items():
        assert f"pictures/{name}" in "".join(GUIDE.texts())
        assert (ROOT / "docs" / "pictures" / name).read_text(encoding="utf-8") == draw()


# ---- the tables ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_every_table_has_the_mistakes_and_messages(name):
    (found,) = [found for page in MESSAGES for found in marked(name).findall(page.read_text(encoding="utf-8"))]
    now = table([(mistake, messages) for mistake, messages, _ in provoked()[name]])
    assert steady(found).splitlines() == steady(now).splitlines(), (
        "run python tests/support/guide_pages.py, and look at what has changed"
    )


@pytest.mark.slow
def test_no_mistake_is_answered_by_another_tools_error():
    for rows in provoked().values():
        for mistake, messages, _ in rows:
            assert messages, f"{mistake.written} is not answered"
            for message in messages:
                assert not re.search(r"Traceback|ufunc|numpy(?!')|NoneType|0x[0-9a-f]{6}|object at", message), message
                assert not message.startswith(("'", " ")) or message[1:2] != "'", message


@pytest.mark.slow
def test_every_error_of_the_code_is_provoked_or_known_to_be_out_of_reach():
    everything = sites(tuple(modules()))
    reached = {place for rows in provoked().values() for _, _, places in rows for place in places}
    missing = [
        site
        for site in everything
        if not any(module == site.module and site.first <= line <= site.last for module, line in reached)
    ]
    unknown = [str(site) for site in missing if not any(words in site.words for words in UNREACHABLE)]
    assert not unknown, "these need a mistake in guide_mistakes_of_*.py, and python tests/support/guide_pages.py:\n" + "\n".join(
        unknown
    )
    for words_ in UNREACHABLE:
        assert any(words_ in site.words for site in missing), f"reached, or no longer in the code: {words_}"
    assert len(everything) > 150


#: Modules in which every text is a warning, or part of one; in the others it is what they append to warnings, or warn of.
HOLDERS = re.compile(r"(checks|results)/warnings\w*|(description|kinematics)/unit_hints|results/near_singular")
#: Words in a row that make a text rather than a part of one.
WORDS = 5


def texts(node: ast.AST) -> Iterator[ast.JoinedStr | ast.Constant]:
    """Yield the texts in a piece of code that are neither of errors nor about the code."""
    if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        yield node
    elif not isinstance(node, ast.Raise) and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
        for child in ast.iter_child_nodes(node):
            yield from texts(child)


def warnings_in(module: ast.Module) -> Iterator[ast.AST]:
    """Yield what a module appends to warnings, or warns of."""
    for node in ast.walk(module):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            to_warnings = node.func.attr in ("append", "extend") and ast.unparse(node.func.value).endswith("warnings")
            if to_warnings or ast.unparse(node.func) == "warnings.warn":
                yield node.args[0]
        elif isinstance(node, ast.AugAssign) and ast.unparse(node.target).endswith("warnings"):
            yield node.value


def warning_patterns() -> dict[str, list[re.Pattern[str]]]:
    """Return, by module, a pattern for every text that the code warns with."""
    found: dict[str, list[re.Pattern[str]]] = {}
    for name in modules():
        module = ast.parse((SOURCE / name).read_text(encoding="utf-8"))
        name = name.removesuffix(".py")
        for text in [item for root in ([module] if HOLDERS.fullmatch(name) else warnings_in(module)) for item in texts(root)]:
            pieces = text.values if isinstance(text, ast.JoinedStr) else [text]
            fixed = [str(piece.value) if isinstance(piece, ast.Constant) else None for piece in pieces]
            if len(re.findall(r"[A-Za-z]{2,}", " ".join(filter(None, fixed)))) >= WORDS:
                pattern = "".join(".*" if piece is None else re.escape(piece) for piece in fixed)
                found.setdefault(name, []).append(re.compile(re.sub("<[a-z]+>", ".*", pattern)))  # <is> is is or are
    return found


@pytest.mark.slow
def test_every_warning_of_the_code_is_in_the_table():
    said = [message for name in ("WARNINGS", "UNITS") for _, messages, _ in provoked()[name] for message in messages]
    patterns = warning_patterns()
    assert {
        "checks/warnings",
        "results/warnings",
        "kinematics/unit_hints",
        "mechanism/topology",
        "mechanism/beam_geometry",
    } <= set(patterns)
    assert sum(map(len, patterns.values())) > 50
    unknown, out_of_reach = [], set()
    for pattern in [item for patterns_of in patterns.values() for item in patterns_of]:
        template = pattern.pattern.replace("\\", "")
        # the place in front of a message is not in the table
        short = re.compile(re.sub(r"^(\.\*:)+\\ ", "", pattern.pattern))
        if any(short.search(message) for message in said):
            continue
        known = [words_ for words_ in WARNINGS_UNREACHABLE if words_ in template]
        out_of_reach.update(known)
        if not known:
            unknown.append(template)
    assert not unknown, "no mistake is answered by:\n" + "\n".join(unknown)
    assert out_of_reach == set(WARNINGS_UNREACHABLE), "these are reached, or no longer in the code"


#: a closed chain that hangs on the ground alone
PENDULUM = (
    '<link name="pendulum"/><joint name="q" type="continuous"><parent link="ground"/><child link="pendulum"/></joint>'
    '<loop name="p" type="revolute"><predecessor link="ground"/><successor link="pendulum"/></loop>'
)


@pytest.mark.parametrize("more", ["", PENDULUM])
def test_check_explains_robots_without_limbs(more, tmp_path):
    file = tmp_path / "drone.urdf"
    file.write_text(
        '<robot name="r"><link name="ground"/><link name="drone"/><joint name="fly" type="floating"><parent link="ground"/>'
        f'<child link="drone"/></joint><platform link="drone"/>{more}</robot>'
    )
    assert any("no limb joins base and platform" in warning for warning in robot_facts(ks.load_robot(file)).warnings)
