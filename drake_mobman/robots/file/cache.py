"""A folder for what is made of models, such as converted meshes, by their content."""

import contextlib
import functools
import os
import tempfile
from pathlib import Path


@functools.cache
def cache_folder() -> Path:
    """Returns a folder of this user, or one for this process if that cannot be made."""
    home = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
    folder = Path(home) / "drake_mobman" / "models"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    if os.access(folder, os.W_OK):
        return folder
    return Path(tempfile.mkdtemp(prefix="drake_mobman_models_"))
