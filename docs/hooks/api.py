"""The API pages: one for each package, with all its public modules."""

from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).parent.parent.parent
FRONT = "api/index.md"

GROUND = "ground"
"""Page of the modules that belong to no package."""


def on_config(config: Any) -> Any:
    """Adds the API's pages to the navigation."""
    pages = [FRONT, *(f"api/{name}.md" for name in packages())]
    config.nav.append({"API": pages})
    return config


def on_files(files: Any, config: Any) -> Any:
    """Adds the API's pages to what is built."""
    files.append(File.generated(config, FRONT, content=front_page()))
    for name, modules in packages().items():
        title = "signals, scalars, parameters" if name == GROUND else name
        parts = [f"# {title}\n", *(f"::: {module}\n" for module in modules)]
        files.append(File.generated(config, f"api/{name}.md", content="\n".join(parts)))
    return files


def packages() -> dict[str, list[str]]:
    """Returns the documented modules by package, all with a docstring."""
    package = ROOT / "drake_mobman"
    found = {GROUND: [_name(path) for path in sorted(package.glob("[a-z]*.py"))]}
    for init in sorted(package.glob("*/__init__.py")):
        modules = sorted(init.parent.rglob("*.py"))
        found[init.parent.name] = [_name(path) for path in modules]
    found["diagrams"] = [
        _name(path) for path in sorted((ROOT / "diagrams").glob("*.py"))
    ]
    return {name: modules for name, modules in found.items() if modules}


def front_page() -> str:
    """Returns the page of the names that `import drake_mobman as mm` gives."""
    import drake_mobman

    lines = [
        "# API\n",
        "`import drake_mobman as mm` gives these names; Drake is imported when the",
        "first of them is used. The pages beside this one hold all modules.\n",
        "| name | what it is |",
        "|---|---|",
    ]
    for name in sorted(getattr(drake_mobman, "__all__", ()), key=str.lower):
        made = getattr(drake_mobman, name)
        if isinstance(made, str):
            lines.append(f"| `mm.{name}` | `{made}` |")
            continue
        home = f"{made.__module__}.{getattr(made, '__name__', name)}"
        home = home.removeprefix("drake_mobman.") if "diagrams" in home else home
        doc = (made.__doc__ or "").strip().partition("\n")[0].replace("|", "\\|")
        link = f'<autoref identifier="{home}" optional><code>mm.{name}</code></autoref>'
        lines.append(f"| {link} | {doc} |")
    return "\n".join(lines) + "\n"


def _name(path: Path) -> str:
    """Returns a module's name; that of a package for its `__init__`."""
    path = path.parent if path.stem == "__init__" else path.with_suffix("")
    return ".".join(path.relative_to(ROOT).parts)
