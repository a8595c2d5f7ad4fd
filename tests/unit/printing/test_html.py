"""Reports as HTML: columns become tables, cell by cell."""

import re

from kinetostatics.printing.html import html_report
from kinetostatics.printing.text import section, table


def cells(html):
    return [re.findall(r"<t[dh].*?>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>(.*?)</tr>", html)]


def test_tables_come_out_cell_by_cell():
    header = ("what", "", "moves o [nm]", "part [%]")
    rows = [("rod of limb 2", "beam", "957.56", "49.9"), ("rod_1", "", "-3.58", "0.2"), ("total", "", "∞", "100.0")]
    report = "\n".join(
        ["Report", *section("A title", [*table(header, rows, "llrr"), "softest along x < y"]), *section("None", [])]
    )
    html = html_report(report)
    assert cells(html) == [list(header), *map(list, rows)]
    assert "<p><strong>Report</strong></p>\n<h3>A title</h3>" in html and "<p>None</p>" in html
    assert "<p>softest along x &lt; y</p>" in html
    assert html.count("<th ") == 4 and html.count('text-align: right">49.9') == 1


def test_names_with_values_have_no_titles():
    report = "\n".join(["Report", *section("Pose", ["links  socket, platform", "mass   19.654 kg", "! beware"])])
    html = html_report(report)
    assert cells(html) == [["links", "socket, platform"], ["mass", "19.654 kg"]] and "<th" not in html
    assert '<p class="warning">! beware</p>' in html


def test_drawings_stay_as_they_are():
    report = "\n".join(["Robot", *section("Limbs", ["limb_1: R S", "  base —joint→ platform", "  mass   1 kg"])])
    assert "<pre>limb_1: R S\n  base —joint→ platform\n  mass   1 kg</pre>" in html_report(report)
