"""Drake's model directives, whose models are read as any others are."""

import hashlib
import re
from collections.abc import Callable
from pathlib import Path

from drake_mobman.files import new_file
from drake_mobman.robots.file.cache import cache_folder
from drake_mobman.robots.file.model import Mimic, Model, Shapes
from drake_mobman.robots.file.packages import Packages

_FILE = re.compile(r"""(\bfile:\s*)(["']?)([^\s"',}]+)\2""")
"""Where a directive names a file."""

_SUFFIXES = {"urdf": ".urdf", "sdf": ".sdf", "xml": ".xml", "dmd.yaml": ".dmd.yaml"}


def directives_model(
    text: str, path: Path, packages: Packages, read: Callable[..., Model]
) -> Model:
    """Returns a model of directives.

    Args:
        text: of the file.
        path: of the file.
        packages: that it may refer to.
        read: reads a model, as `read_model`.

    Raises:
        ParameterError: where one of its models cannot be used.
    """
    uris = {match[3] for match in _FILE.finditer(text)}
    models = {uri: read(uri, packages, path.parent) for uri in sorted(uris)}
    efforts: dict[str, float] = {}
    mimics: dict[str, Mimic] = {}
    files: dict[Path, None] = {}
    for model in models.values():
        efforts |= model.efforts
        mimics |= model.mimics
        files |= dict.fromkeys([model.path, *model.meshes])

    def written(shapes: Shapes) -> str:
        def moved(match: re.Match[str]) -> str:
            model = models[match[3]]
            return f"{match[1]}{_kept(model.text(shapes), model.kind).as_uri()}"

        return _FILE.sub(moved, text)

    return Model(path, "dmd.yaml", written, efforts, mimics, tuple(files))


def _kept(text: str, kind: str) -> Path:
    """Returns a file with this text, from the cache or new."""
    digest = hashlib.sha256(text.encode()).hexdigest()[:24]
    file = cache_folder() / f"{digest}{_SUFFIXES[kind]}"
    if not file.exists():
        with new_file(file) as draft:
            draft.write_text(text)
    return file
