"""What the README and the pages show works: Python, commands and links."""

import re
import shlex
import sys
import types
from pathlib import Path

import pytest
import typer

from drake_mobman.cli.app import app
from drake_mobman.scenario import load_scenario

ROOT = Path(__file__).parent.parent.parent
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
TEXTS = {str(path.relative_to(ROOT)): path.read_text() for path in PAGES}

PYTHON = [
    pytest.param(code, id=f"{name}-{i}")
    for name, text in TEXTS.items()
    if name != "CONTRIBUTING.md"  # Its code is what a file looks like.
    for i, code in enumerate(re.findall(r"```python\n(.*?)```", text, re.DOTALL))
]
COMMANDS = sorted(
    {
        line.strip()
        for text in TEXTS.values()
        for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
        for line in re.split(r"\n|&&", block)
        if re.match(r"\s*(\.venv/bin/)?mobman ", line)
    }
)


@pytest.fixture
def module(monkeypatch):
    """A module to run code in, as a file of one's own would be."""
    made = types.ModuleType("page")
    monkeypatch.setitem(sys.modules, "page", made)
    return made


@pytest.mark.parametrize("code", PYTHON)
def test_python_of_the_pages_runs(code, module):
    exec(compile(code, "page", "exec"), module.__dict__)


@pytest.mark.parametrize("line", COMMANDS)
def test_command_of_the_pages_is_one(line):
    _, *arguments = shlex.split(line.partition(" > ")[0], comments=True)
    command = typer.main.get_command(app)
    while hasattr(command, "commands"):
        name, *arguments = arguments
        command = command.commands[name]
    context = command.make_context(name, arguments)
    overrides = context.params.get("set_") or []
    given = context.params.get("scenarios") or [context.params.get("scenario")]
    for scenario in filter(None, given):
        if not scenario.startswith("my_"):  # Which another command on the page makes.
            load_scenario(scenario, overrides)


def test_commands_were_found():
    assert len(COMMANDS) >= 10


@pytest.mark.parametrize("name", TEXTS)
def test_links_of_a_page_lead_to_files(name):
    folder = (ROOT / name).parent
    text = re.sub(r"```.*?```", "", TEXTS[name], flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not target.startswith(("http", "#")):
            assert (folder / target.partition("#")[0]).exists(), target


def test_own_decomposer_takes_fifteen_lines():
    (code,) = re.findall(
        r"```python\n(.*?)```", TEXTS["docs/extend/decomposer.md"], re.DOTALL
    )
    lines = [
        line
        for line in code.splitlines()
        if line.strip() and "import" not in line and '"""' not in line
    ]
    assert len(lines) <= 15


def test_readme_is_short():
    assert len(TEXTS["README.md"].splitlines()) <= 130
