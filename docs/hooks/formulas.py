"""Formulas become MathML when the site is built: browsers show it without any script."""

from __future__ import annotations

import html
import re

from math_core import LatexToMathML
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Return a page's HTML with its formulas as MathML; a formula that is wrong ends the build."""
    converter = LatexToMathML()

    def mathml(found: re.Match[str]) -> str:
        formula = html.unescape(found[3]).strip()
        return converter.convert_with_local_state(formula, displaystyle=found[2] == "[")

    return FORMULA.sub(mathml, content)
