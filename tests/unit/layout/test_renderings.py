"""Reports as text, with and without colours, and as HTML: tables, wrapped lines, sentences, drawings."""

import io
import re

import pytest

from kinetostatics.layout.blocks import (
    Column,
    Facts,
    Lines,
    Number,
    ReportSection,
    Table,
    Text,
    Word,
    warning_section,
    without_repetitions,
)
from kinetostatics.layout.numbers import FORCES, LENGTHS, NumberFormat
from kinetostatics.layout.renderings import WIDTH, block_lines, use_colour, wrapped
from kinetostatics.layout.report import Report

CODE = re.compile("\033\\[[0-9;]*m")


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(autouse=True)
def plain_environment(monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")


@pytest.mark.parametrize(
    ("stream", "environment", "wanted"),
    [
        (Terminal(), {}, True),
        (io.StringIO(), {}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (Terminal(), {"NO_COLOR": "1"}, False),
        (io.StringIO(), {"FORCE_COLOR": "1"}, True),
        (io.StringIO(), {"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
        (Terminal(), {"FORCE_COLOR": "1", "TERM": "dumb"}, True),
    ],
)
def test_colour_follows_terminal_and_environment(monkeypatch, stream, environment, wanted):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert use_colour(stream) is wanted


def test_tables_are_aligned_and_wide_ones_split():
    rows = [("left", "1", Number.of(22.0, FORCES)), ("x", "333", None)]
    assert block_lines(Table.of_rows(("a", "bb", "c"), rows, "lrl")) == ["a      bb  c", "left    1  22.000 N", "x     333"]
    assert block_lines(Table.of_rows(("a", "b", "c"), [("x", "y", "long")]))[1] == "x  y  long"  # the first left, others right
    names = [f"column_{k:02}" for k in range(12)]
    wide = block_lines(Table.of_rows(("name", *names), [("row", *map(str, range(12)))], wide=True))
    assert max(map(len, wide)) <= WIDTH and wide[0].split()[0] == wide[3].split()[0] == "name" and wide[2] == ""
    assert len(wide) == 5 and wide[0].split()[1:] + wide[3].split()[1:] == names
    assert len(wide[0].split()) - 1 == (WIDTH - 6) // 11
    columns = [Column("name", ["x", "y"]), Column.of("force", [1.0, None], NumberFormat.of(1.0, FORCES))]
    assert block_lines(Table(columns)) == ["name  force [N]", "x        1.0000", "y"]
    assert Column.of("n", [2.0], FORCES, with_unit=False).heading == "n"


def test_text_of_facts_sentences_and_drawings():
    rows = [("mass", Number.of(2.0, FORCES)), ("names", ["a", "b"])]
    assert block_lines(Facts(rows, indent=1)) == [" mass   2.0000 N", " names  a", "        b"]
    assert wrapped("one two three", "- ", 9) == ["- one two", "  three"] and wrapped("", "- ") == ["-"]
    assert block_lines(Text("so", "item")) == ["- so"] and block_lines(Lines(["a —j→ b"])) == ["a —j→ b"]
    assert without_repetitions(["a", "a", "b", "a", "a"]) == ["a", "", "b", "a", ""] and without_repetitions([]) == []


def test_ranges_of_numbers_have_one_unit():
    assert str(Number.range_of([1.0, 2.0, float("nan")], FORCES)) == "1.000 to 2.000 N"
    assert str(Number.range_of(3.0, FORCES)) == "3.000 N" and str(Number.range_of([float("nan")], FORCES)) == "–"
    assert str(Number.range_of(1e-12, LENGTHS, 1e-9)) == "0 µm" and str(Number.range_of(0.5, (("°", 1.0),))) == "0.5000°"


@pytest.fixture
def report():
    states = [Text(", so", lead=Word("SINGULAR", "bad"))]
    table = Table.of_rows(("status", "poses"), [(Word("OK", "good"), "3")])
    return Report(
        ("Analysis of 'OK': ", Word("SINGULAR", "bad")),
        lambda: [
            ReportSection(None, states),
            ReportSection("Status", [table], "status"),
            ReportSection("More", [Text("all")], "more", detail=True),
            ReportSection("None", []),
            ReportSection("", [Text("at the margin")]),
            warning_section(["the rod is long " * 8]),
        ],
        lambda: {"number": float("nan"), "names": ("a", "b")},
    )


def test_coloured_report_differs_only_by_colour_codes(report):
    assert report.text(colour=True).split("\n")[:4] == [
        "\033[1mAnalysis of 'OK': \033[0m\033[31mSINGULAR\033[0m",
        "  \033[31mSINGULAR\033[0m, so",
        "",
        "\033[1mStatus\033[0m",
    ]
    assert "  \033[32mOK\033[0m          3" in report.text(colour=True)
    assert report.text(colour=True).count("\033[33m") == 2, "both lines of the warning"
    plain = CODE.sub("", report.text(colour=True))
    assert plain == report.text() == str(report) and "None" not in plain and "\nat the margin\n" in plain
    for line in report.text(colour=True).split("\n"):
        codes = CODE.findall(line)
        assert codes[1::2] == ["\033[0m"] * (len(codes) // 2) and len(codes) % 2 == 0


def test_brief_and_only_select_sections(report):
    assert "More" in str(report) and "More" not in str(report.brief()) and "Warnings" in str(report.brief())
    assert str(report.only("more")).splitlines() == ["Analysis of 'OK': SINGULAR", "  SINGULAR, so", "", "More", "  all"]
    with pytest.raises(ValueError, match="no section 'mor': did you mean 'more'"):
        report.only("mor")
    assert repr(report) == "<Analysis of 'OK': SINGULAR>" and report.to_dict() == {"number": None, "names": ["a", "b"]}
    assert str(Report("a", lambda: [warning_section([])])) == "a\n\nWarnings\n  none"


# ---- HTML -------------------------------------------------------------------------------------------------------------


def cells(html):
    return [re.findall(r"<t[dh].*?>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>(.*?)</tr>", html)]


def html_of(*blocks):
    return Report("Report", lambda: [ReportSection("A title", blocks)]).html()


def test_html_of_tables_and_sentences():
    header = ("what", "", "moves o [nm]", "part [%]")
    rows = [("rod of limb 2", "beam", "957.56", "49.9"), ("total", "", "∞", "100.0")]
    html = html_of(Table.of_rows(header, rows, "llrr"), Text("softest along x < y"), Text("beware", "warning"))
    assert cells(html) == [list(header), *map(list, rows)]
    assert html.startswith("<p><strong>Report</strong></p>\n<h3>A title</h3>")
    assert "<p>softest along x &lt; y</p>" in html and '<p class="warning">! beware</p>' in html
    assert html.count("<th ") == 4 and html.count('text-align: right">49.9') == 1


def test_html_of_facts_and_drawings():
    html = html_of(Facts([("links", "socket, platform"), ("names", ["a", "b"])]), Lines(["base —joint→ platform", "  mass"]))
    assert cells(html) == [["links", "socket, platform"], ["names", "a<br>b"]] and "<th" not in html
    assert "<pre>base —joint→ platform\n  mass</pre>" in html
