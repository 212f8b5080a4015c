"""The wheel: one top-level name, with all that the installed package needs."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def wheel_names(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    tree = folder / "tree"  # A copy: building leaves files behind.
    for name in ("drake_mobman", "diagrams", "scenarios"):
        shutil.copytree(ROOT / name, tree / name)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    options = ["--no-build-isolation", "--wheel-dir", folder]
    subprocess.run([*pip, *options, tree], check=True)
    (wheel,) = folder.glob("*.whl")
    return zipfile.ZipFile(wheel).namelist()


def test_wheel_has_one_top_level_name(wheel_names):
    tops = {name.split("/")[0] for name in wheel_names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"drake_mobman"}


def test_wheel_holds_every_file_of_the_package(wheel_names):
    places = {"drake_mobman": "drake_mobman", "diagrams": "drake_mobman/diagrams"}
    places["scenarios"] = "drake_mobman/scenarios"
    for folder, place in places.items():
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in {".py", ".urdf", ".yaml", ".typed", ".js", ".css"}:
                assert f"{place}/{path.relative_to(ROOT / folder)}" in wheel_names
