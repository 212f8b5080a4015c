"""Tables of Markdown."""

from collections.abc import Sequence


def markdown_table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Returns a table of Markdown: names to the left, numbers to the right.

    Columns are padded, so that the plain text is easy to read, too.

    Args:
        heading: of each column.
        rows: of cells, a name and numbers.
    """
    cells = [[text.replace("|", r"\|") for text in row] for row in (heading, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join(
        "| "
        + " | ".join(
            text.rjust(width) if i else text.ljust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        + " |"
        for row in (cells[0], rule, *cells[1:])
    )
