"""Names of a package that are imported when they are first used (PEP 562).

The package lists its imports once, below `if TYPE_CHECKING:`, where type checkers and
editors read them. Nothing there is run; the same lines are read for where a name is.
A class that is not listed is looked for in the package's parts, so that a new block is
there as soon as its file is.
"""

import ast
import importlib
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any


def lazy_getattr(package: str, parts: Sequence[str] = ()) -> Callable[[str], Any]:
    """Returns what imports a name of a package: its `__getattr__`.

    Args:
        package: its name.
        parts: subpackages where to look for classes that it does not list.
    """

    def imported(name: str) -> Any:
        module = sys.modules[package]
        at = modules_of(package).get(name)
        # Python itself looks for other names, as those of modules, at any time.
        if not at and name[:1].isupper():
            at = _classes(package, *parts).get(name)
        if not at:
            message = f"module {package!r} has no attribute {name!r}"
            raise AttributeError(message, name=name, obj=module)
        value = getattr(importlib.import_module(at), name)
        setattr(module, name, value)  # So that it is looked up once.
        return value

    return imported


@cache
def modules_of(package: str) -> dict[str, str]:
    """Returns where a package has its names from: modules by name."""
    loader: Any = sys.modules[package].__spec__.loader  # type: ignore[union-attr]
    for node in ast.parse(loader.get_source(package)).body:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            lines = (x for x in node.body if isinstance(x, ast.ImportFrom))
            return {name.name: str(x.module) for x in lines for name in x.names}
    raise ValueError(f"{package} has no `if TYPE_CHECKING:`")


@cache
def _classes(package: str, *parts: str) -> dict[str, str]:
    """Returns where the classes in some parts of a package are: modules by name."""
    (folder,) = sys.modules[package].__path__
    found = {}
    for part in parts:
        for file in sorted(Path(folder, part).glob("*.py")):
            for node in ast.parse(file.read_text("utf-8")).body:
                if isinstance(node, ast.ClassDef):
                    found[node.name] = f"{package}.{part}.{file.stem}"
    return found
