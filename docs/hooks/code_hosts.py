"""Pages mean on the site what they mean on code hosts, where they are read as well.

Links lead to files outside ``docs/``, which come along, and to headings of any kind; ``\\|`` is a bar in tables, in code too.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
#: a link to a file that stands beside ``docs/``: its path from the top of the project
OUTSIDE = re.compile(r"\]\((?:\.\./)+((?:robots|examples|tests|benchmarks)/[\w./-]+)\)")
ROW, CODE = re.compile(r"^\|.*$", re.MULTILINE), re.compile(r"`[^`\n]+`")


def on_config(config: MkDocsConfig) -> None:
    """Name headings as code hosts do, where the pages are read as well: ``<loop>`` has the anchor ``loop``."""
    config.mdx_configs["toc"]["slugify"] = lambda text, separator: re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", separator)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the files that pages link to."""
    texts = [file.content_string for file in files.documentation_pages()]
    for path in sorted({path for text in texts for path in OUTSIDE.findall(text)}):
        if (ROOT / path).is_file():
            files.append(File.generated(config, path, abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links to such files lead to their copies, and free bars in the code of tables, which needs no escape here."""
    folder = posixpath.dirname(page.file.src_uri)
    text = OUTSIDE.sub(lambda found: f"]({posixpath.relpath(found[1], folder)})", markdown)
    return ROW.sub(lambda row: CODE.sub(lambda code: code[0].replace("\\|", "|"), row[0]), text)
