"""`mobman robot`: robot files checked, drafted, and given scenarios that fit."""

import typer

from drake_mobman.cli.robot.check import check
from drake_mobman.cli.robot.new import new
from drake_mobman.cli.robot.scenario import scenario

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
for _command in (check, new, scenario):
    app.command()(_command)
