"""Formulas become MathML when the site is built: browsers show it without any script."""

from __future__ import annotations

import html
import re

from math_core import LatexToMathML
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

CODE = re.compile(r"<(pre|code|script|iframe)\b.*?</\1>", re.DOTALL)
LEFT = re.compile(r"\$[^$<]*\\[a-z][^$<]*\$")
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Return a page's HTML with its formulas as MathML; a formula that is wrong ends the build."""
    converter = LatexToMathML()

    def mathml(found: re.Match[str]) -> str:
        formula = html.unescape(found[3]).strip()
        return converter.convert_with_local_state(formula, displaystyle=found[2] == "[")

    found = FORMULA.sub(mathml, content)
    if left := LEFT.search(CODE.sub("", found)):  # such as $x = $, with a space before its end
        raise PluginError(f"{page.file.src_uri}: this formula is not shown as one: {left[0]}")
    return found
