"""Reports as HTML: tables cell by cell, drawings as they are, everything escaped."""

import re

from kinetostatics.layout.blocks import Facts, Lines, ReportSection, Table, Text
from kinetostatics.layout.report import Report


def cells(html):
    return [re.findall(r"<t[dh].*?>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>(.*?)</tr>", html)]


def html_of(*blocks):
    return Report("Report", lambda: [ReportSection("A title", blocks)]).html()


def test_tables_and_sentences():
    header = ("what", "", "moves o [nm]", "part [%]")
    rows = [("rod of limb 2", "beam", "957.56", "49.9"), ("total", "", "∞", "100.0")]
    html = html_of(Table.of_rows(header, rows, "llrr"), Text("softest along x < y"), Text("beware", "warning"))
    assert cells(html) == [list(header), *map(list, rows)]
    assert html.startswith("<p><strong>Report</strong></p>\n<h3>A title</h3>")
    assert "<p>softest along x &lt; y</p>" in html and '<p class="warning">! beware</p>' in html
    assert html.count("<th ") == 4 and html.count('text-align: right">49.9') == 1


def test_facts_and_drawings():
    html = html_of(Facts([("links", "socket, platform"), ("names", ["a", "b"])]), Lines(["base —joint→ platform", "  mass"]))
    assert cells(html) == [["links", "socket, platform"], ["names", "a<br>b"]] and "<th" not in html
    assert "<pre>base —joint→ platform\n  mass</pre>" in html
