"""A diagram drawn as a graph."""

import shutil
import subprocess
from pathlib import Path

from pydrake.systems.framework import Diagram, InputPortIndex

from drake_mobman.files import new_file


class GraphError(OSError):
    """A graph that cannot be drawn; the message is one line."""


def graphviz(diagram: Diagram) -> str:
    """Returns a diagram in Graphviz's language: blocks, and the signals between them.

    Drake's own `GetGraphvizString` draws every port and every export, which hides the
    loop in a diagram that exports each signal.
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
    for (target, _), (source, port) in diagram.connection_map().items():
        signal = source.get_output_port(port).get_name()
        edge = f'"{source.get_name()}" -> "{target.get_name()}"'
        lines.append(f'{edge} [label="{signal}"];')
    for i in range(diagram.num_input_ports()):
        name = diagram.get_input_port(i).get_name()
        for target, _ in diagram.GetInputPortLocators(InputPortIndex(i)):
            lines.append(f'"{name}" [shape=plaintext, style=""];')
            lines.append(f'"{name}" -> "{target.get_name()}";')
    return "\n".join([*lines, "}", ""])


def graph_of(diagram: Diagram, file: Path) -> bytes:
    """Returns a diagram as the content of `file`, in the format of its suffix.

    That is `.svg`, or `.dot` for Graphviz's own language.

    Raises:
        GraphError: if the suffix is neither, or for `.svg` if Graphviz is missing.
    """
    text = graphviz(diagram).encode()
    if file.suffix == ".dot":
        return text
    if file.suffix != ".svg":
        raise GraphError(f"{file}: must end in .svg or .dot")
    dot = shutil.which("dot")
    if dot is None:
        raise GraphError(
            f"{file}: needs Graphviz's program `dot`, which is not installed; "
            "install the system package graphviz, or name a file that ends in .dot"
        )
    drawn = subprocess.run([dot, "-Tsvg"], input=text, capture_output=True, check=False)
    if drawn.returncode:
        why = " ".join(drawn.stderr.decode(errors="replace").split())
        raise GraphError(f"{file}: not drawn, `dot` ended by {drawn.returncode} {why}")
    return drawn.stdout


def write_graph(content: bytes, file: Path) -> None:
    """Writes a graph to `file`, whole or not at all.

    Raises:
        OSError: where it cannot be written.
    """
    with new_file(file) as draft:
        draft.write_bytes(content)
