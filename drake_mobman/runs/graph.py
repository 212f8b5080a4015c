"""The wired diagram, drawn."""

import shutil
import subprocess
from pathlib import Path

from pydrake.systems.framework import Diagram, InputPortIndex


class GraphError(OSError):
    """A graph that cannot be drawn; the message is one line."""


def graphviz(diagram: Diagram) -> str:
    """Returns a diagram in Graphviz's language: blocks, and the signals between them.

    Drake's own `GetGraphvizString` draws every port, and an edge for every port that is
    exported; with each signal exported, the loop itself is lost among them.
    """
    lines = [
        f'digraph "{diagram.get_name()}" {{',
        "rankdir=LR; nodesep=0.35; ranksep=0.6;",
        'node [shape=box, style="rounded,filled", fillcolor="#eef3f8", '
        'fontname="Helvetica", fontsize=11];',
        'edge [fontname="Helvetica", fontsize=9, color="#3b4a5a", arrowsize=0.7];',
    ]
    for system in diagram.GetSystems():
        kind = type(system).__name__.partition("_")[0]
        kind = "" if kind == "Diagram" else f"\\n{kind}"
        lines.append(f'"{system.get_name()}" [label="{system.get_name()}{kind}"];')
    for (taker, _), (giver, port) in diagram.connection_map().items():
        signal = giver.get_output_port(port).get_name()
        edge = f'"{giver.get_name()}" -> "{taker.get_name()}"'
        lines.append(f'{edge} [label="{signal}"];')
    for i in range(diagram.num_input_ports()):
        name = diagram.get_input_port(i).get_name()
        for taker, _ in diagram.GetInputPortLocators(InputPortIndex(i)):
            lines.append(f'"{name}" [shape=plaintext, style=""];')
            lines.append(f'"{name}" -> "{taker.get_name()}";')
    return "\n".join([*lines, "}", ""])


def write_graph(diagram: Diagram, file: Path) -> None:
    """Draws a diagram to `file`: `.svg`, or `.dot` for Graphviz's own language.

    Raises:
        GraphError: if the suffix is neither, or `.svg` is asked without Graphviz.
    """
    text = graphviz(diagram)
    if file.suffix == ".dot":
        drawn = text
    elif file.suffix == ".svg":
        dot = shutil.which("dot")
        if dot is None:
            raise GraphError(
                f"{file}: needs Graphviz's program `dot`, which is not installed; "
                "install the system package graphviz, or name a file that ends in .dot"
            )
        drawn = subprocess.run(
            [dot, "-Tsvg"], input=text, capture_output=True, text=True, check=True
        ).stdout
    else:
        raise GraphError(f"{file}: must end in .svg or .dot")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(drawn)
    except OSError as error:
        raise GraphError(f"{file}: cannot be written, {error.strerror}") from None
