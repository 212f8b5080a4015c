"""Names of a package that are imported when they are first used (PEP 562).

The package lists its imports once, below `if TYPE_CHECKING:`, where type checkers and
editors read them. Nothing there is run; the same lines are read for where a name is.
"""

import ast
import importlib
import sys
from collections.abc import Callable
from functools import cache
from typing import Any


def lazy_getattr(package: str) -> Callable[[str], Any]:
    """Returns what imports a name of a package: its `__getattr__`."""

    def imported(name: str) -> Any:
        module = sys.modules[package]
        if name not in modules_of(package):
            message = f"module {package!r} has no attribute {name!r}"
            raise AttributeError(message, name=name, obj=module)
        value = getattr(importlib.import_module(modules_of(package)[name]), name)
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
