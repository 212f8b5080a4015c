"""`mobman export`: laws, written for the tools of others."""

import typer

from drake_mobman.cli.export.law import law

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.command()(law)


@app.callback()
def export() -> None:
    """Writes laws for the tools of others."""
