"""Notebooks: the scripts of ``docs/tutorials/notebooks/`` are run when the site is built, and become pages.

A script is in jupytext's percent format, its page holds all that it shows, and an assertion that fails ends the build.
``EXECUTE_NOTEBOOKS=false mkdocs build`` is quicker: the pages then show the code alone.
"""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import jupytext
import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from nbclient import NotebookClient

FOLDER = "tutorials/notebooks/"
ROOT = Path(__file__).resolve().parents[2]
#: Stands in a page's Markdown for what a cell shows.
OUTPUT = re.compile(r"<!-- output (\d+) -->")
#: A link to a notebook from another folder.
LINK = re.compile(r"(\]\([\w./]*notebooks/\w+)\.py([)#])")

_shown: list[str] = []


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Make a page of each notebook; the script itself can be downloaded beside it."""
    scripts = {file.src_uri: file for file in files if file.src_uri.startswith(FOLDER) and file.src_uri.endswith(".py")}
    notebooks = {name: jupytext.read(file.abs_src_path) for name, file in scripts.items()}
    if os.environ.get("EXECUTE_NOTEBOOKS", "true") != "false":
        execute(notebooks)
    _shown.clear()
    for name, notebook in notebooks.items():
        text = "\n\n".join(_markdown(notebook.cells))
        text += (
            f"\n\n---\n\n[This page as a notebook]({Path(name).name}): jupytext's percent format, for Jupyter and most editors.\n"
        )
        files.append(File.generated(config, name.removesuffix(".py") + ".md", content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links to scripts lead to their pages; those are links that also work in the source."""
    return LINK.sub(r"\1.md\2", markdown)


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put in what the cells show, which is no Markdown."""
    return OUTPUT.sub(lambda found: _shown[int(found[1])], content)


def execute(notebooks: Mapping[str, nbformat.NotebookNode]) -> None:
    """Run notebooks one after the other in one kernel, whose names are forgotten between them.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell fails.
    """
    cells = []
    for notebook in notebooks.values():
        cells += [nbformat.v4.new_code_cell("%reset -f"), *notebook.cells]
    client = NotebookClient(
        nbformat.v4.new_notebook(cells=cells),
        kernel_name="python3",
        timeout=300,
        resources={"metadata": {"path": str(ROOT)}},
        extra_arguments=["--log-level=ERROR"],
    )
    client.execute(env={**os.environ, "TQDM_DISABLE": "1"})  # bars that are gone at the end


def _markdown(cells: list[nbformat.NotebookNode]) -> Iterator[str]:
    for cell in cells:
        if cell.cell_type == "markdown":
            yield cell.source
            continue
        yield f"```python\n{cell.source}\n```"
        for output in cell.get("outputs", ()):
            found = _html(output)
            if found:
                _shown.append(f'<div class="output">{found}</div>')
                yield f"<!-- output {len(_shown) - 1} -->"


def _html(output: nbformat.NotebookNode) -> str:
    """Return what one output shows; nothing for messages on standard error."""
    if output.output_type == "stream":
        return f"<pre>{html.escape(output.text)}</pre>" if output.name == "stdout" else ""
    data = output.get("data", {})
    if "application/vnd.jupyter.widget-view+json" in data:  # a progress bar
        return ""
    if "text/html" in data:
        return str(data["text/html"])
    if "image/png" in data:
        return f'<img alt="figure" src="data:image/png;base64,{data["image/png"].strip()}">'
    return f"<pre>{html.escape(data['text/plain'])}</pre>" if "text/plain" in data else ""
