"""Makes the drawings of the documentation: the loop, and the layers of the package.

    python docs/make_drawings.py

The layers are drawn as the imports in the source have them. It needs Graphviz.
"""

import ast
import subprocess
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDER = Path(__file__).parent / "pictures"

INK, BLUE, ORANGE = "#7d8590", "#3d95cf", "#d9702b"
LOOK = f"""
  bgcolor=transparent; rankdir={{direction}}; nodesep=0.25; ranksep=0.28;
  node [shape=box, style=rounded, color="{INK}", fontcolor="{INK}",
        fontname="sans-serif", fontsize=12, height=0.4];
  edge [color="{INK}", fontcolor="{INK}", fontname="monospace", fontsize=10,
        arrowsize=0.7];
"""

LOOP = f"""
  source [label="source"]; guard; decomposer [color="{BLUE}", fontcolor="{BLUE}"];
  smoother; inverse [label="arm inverse"];
  robot [color="{ORANGE}", fontcolor="{ORANGE}"];
  source -> guard [label="ee_command"];
  guard -> decomposer;
  decomposer -> smoother [label="base_command"];
  decomposer -> inverse [label="arm_command"];
  smoother -> robot [label="base_command_\\nsmoothed"];
  inverse -> robot [label="arm_velocity_\\ncommand"];
  smoother -> decomposer [constraint=false, style=dashed];
  robot -> decomposer [constraint=false, style=dashed,
                       label="ee_cylindrical, arm_position"];
"""


def packages() -> dict[str, Path]:
    """Returns the folders of the package by name."""
    inits = sorted((ROOT / "drake_mobman").glob("*/__init__.py"))
    return {init.parent.name: init.parent for init in inits} | {
        "diagrams": ROOT / "diagrams"
    }


def imported(path: Path, names: set[str]) -> Iterator[str]:
    """Yields the packages that a module imports as it is loaded.

    The command line imports what a command needs when it runs.
    """
    tree = ast.parse(path.read_text())
    nodes = ast.walk(tree) if "cli" in path.parts else tree.body
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            parts = node.module.split(".")
            inside = parts[1:2] or [alias.name for alias in node.names]
            yield from (x for x in inside if parts[0] == "drake_mobman" and x in names)


def layers() -> str:
    """Returns the packages and their imports, in Graphviz's language."""
    folders = packages()
    edges = {
        (name, other)
        for name, folder in folders.items()
        for path in folder.rglob("*.py")
        for other in imported(path, set(folders))
        if other != name
    }
    lines = [f"  {name} -> {other};" for name, other in sorted(edges)]
    return "\n".join([*(f"  {name};" for name in folders), *lines])


def draw(name: str, content: str, direction: str, reduced: bool = False) -> None:
    """Writes a drawing; `reduced` leaves out arrows that follow from others."""
    text = f"digraph {{{LOOK.format(direction=direction)}{content}}}"
    if reduced:
        text = subprocess.run(
            ["tred"], input=text, capture_output=True, text=True, check=True
        ).stdout
    path = FOLDER / f"{name}.svg"
    command = ["dot", "-Tsvg", "-o", str(path)]
    subprocess.run(command, input=text, text=True, check=True)
    print(path)


if __name__ == "__main__":
    draw("loop", LOOP, "LR")
    draw("layers", layers(), "TB", reduced=True)
