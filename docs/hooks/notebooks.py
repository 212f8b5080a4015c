"""Notebooks as pages: executed at build, so that what they show is true today.

They are stored without outputs. One that raises ends the build.
"""

import base64
import re
from pathlib import Path
from typing import Any

import nbformat
from mkdocs.structure.files import File
from nbclient import NotebookClient

FOLDER = "notebooks"
TIMEOUT = 300  # Of a cell [s].

_STYLE = re.compile(r"<style.*?</style>", re.DOTALL)


def on_files(files: Any, config: Any) -> Any:
    """Adds a page for each notebook, and its pictures."""
    for path in sorted((Path(config.docs_dir) / FOLDER).glob("*.ipynb")):
        page, pictures = rendered(path)
        address = f"{FOLDER}/{path.stem}.md"
        files.append(File.generated(config, address, content=page))
        for name, content in pictures.items():
            address = f"{FOLDER}/{name}"
            files.append(File.generated(config, address, content=content))
    return files


def on_page_markdown(text: str, **_: Any) -> str:
    """Returns a page's text with its links to notebooks to their pages.

    In the tree, they lead to the notebooks themselves.
    """
    return text.replace(".ipynb)", ".md)")


def rendered(path: Path) -> tuple[str, dict[str, bytes]]:
    """Executes a notebook; returns it as Markdown, and its pictures by file name."""
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=TIMEOUT, kernel_name="python3").execute()
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in _joined(cell.outputs):
            name = f"{path.stem}_{len(pictures) + 1}.png"
            shown, picture = _shown(output, name)
            parts.append(shown)
            if picture:
                pictures[name] = picture
    parts.insert(1, f'<a href="{path.name}" download>The notebook</a>')
    return "\n\n".join(filter(None, parts)) + "\n", pictures


def _joined(outputs: list[Any]) -> list[Any]:
    """Returns a cell's outputs, with what is printed in one piece."""
    found: list[Any] = []
    for output in outputs:
        if found and output.output_type == found[-1].output_type == "stream":
            found[-1].text += output.text
        else:
            found.append(output)
    return found


def _shown(output: Any, name: str) -> tuple[str, bytes]:
    """Returns a cell's output as Markdown, and the picture in it, if it is one."""
    if output.output_type == "stream":
        return _verbatim(output.text), b""
    data = output.get("data", {})
    if "image/png" in data:
        return f"![Drawn by the cell above]({name})", base64.b64decode(
            data["image/png"]
        )
    if "text/html" in data:
        # On one line, so that Markdown leaves it alone.
        inside = " ".join(_STYLE.sub("", data["text/html"]).split())
        return f'<div class="output">{inside}</div>', b""
    return _verbatim(data.get("text/plain", "")), b""


def _verbatim(text: str) -> str:
    return f"```text\n{text.rstrip()}\n```" if text.strip() else ""
