"""Imports run downward only: each module imports from its own layer, or from below."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]

LAYERS = (
    (
        *("blocks", "compiled", "exit_status", "files", "frames", "kinds", "lazy"),
        *(
            "output",
            "parts",
            "parameters",
            "scalars",
            "scenario_files",
            "schema",
            "signals",
            "subexpressions",
            "tracing",
            "operations",
            "step_law",
            "machine_code",
            "machine_block",
        ),
        *("meshcat", "terminal", "ticks"),
    ),
    ("arm", "engines"),
    ("robot_model",),
    ("base",),
    ("decomposers", "estimation", "guidance", "teleop"),
    ("robots",),
    ("scenario",),
    ("diagrams",),
    ("simulation",),
    ("batch",),
    ("analysis",),
    ("figures",),
    ("export",),
    ("benchmarking",),
    ("report",),
    ("cli", "console"),
)
"""Packages and modules of `drake_mobman`, from the ground up."""

FRONT_DOORS = ("__init__", "__main__", "notebook")
"""Modules above all others: the package's own names, and how it is started."""

HEIGHTS = {name: height for height, names in enumerate(LAYERS) for name in names}


def part_of(module):
    """Returns the part of the package that a module belongs to; None if outside."""
    package, _, rest = module.partition(".")
    return rest.partition(".")[0] if package == "drake_mobman" and rest else None


def sources():
    """Yields the files of the package and their parts; `diagrams` lies beside it."""
    for file in sorted((ROOT / "drake_mobman").rglob("*.py")):
        inside = file.relative_to(ROOT / "drake_mobman")
        yield file, inside.parts[0].removesuffix(".py")
    for file in sorted((ROOT / "diagrams").glob("*.py")):
        yield file, "diagrams"


def imported(file):
    """Yields line and name of each module of the package that a file imports."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.lineno, node.module
            # `from drake_mobman import signals` imports a module, too.
            yield from ((node.lineno, f"{node.module}.{a.name}") for a in node.names)


def upward(file, part):
    """Returns a line on each import of a file from a layer above its own."""
    found = {}
    for line, module in imported(file):
        target = part_of(module)
        if target in HEIGHTS and HEIGHTS[target] > HEIGHTS[part]:
            where = f"{file.relative_to(ROOT)}:{line}"
            found.setdefault(where, f"{where} ({part}) imports {module} ({target})")
    return list(found.values())


def test_every_part_of_the_package_has_a_layer():
    parts = {part for _, part in sources()} - {*FRONT_DOORS}
    assert parts - HEIGHTS.keys() == set()


def test_no_module_imports_from_a_layer_above_its_own():
    wrong = [
        line
        for file, part in sources()
        if part in HEIGHTS
        for line in upward(file, part)
    ]
    assert not wrong, "upward imports:\n" + "\n".join(wrong)


def test_an_upward_import_is_found_with_its_file_and_module(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    file = tmp_path / "law.py"
    file.write_text(
        "from drake_mobman import signals\n"
        "from drake_mobman.arm.limits import JointLimits\n"
        "def late():\n"
        "    from drake_mobman import figures\n"
        "    import drake_mobman.cli.app\n"
    )
    assert upward(file, "base") == [
        "law.py:4 (base) imports drake_mobman.figures (figures)",
        "law.py:5 (base) imports drake_mobman.cli.app (cli)",
    ]
