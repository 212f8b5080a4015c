"""Packages are found where robot makers and package managers leave them."""

import sys

import pytest

from drake_mobman.parameters import ParameterError
from drake_mobman.robots.file import packages
from drake_mobman.robots.file.packages import Packages, package_names


@pytest.fixture
def nowhere(tmp_path, monkeypatch):
    """No package is anywhere, but where a test puts it."""
    for name in packages._VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    packages._found.cache_clear()
    return tmp_path


def made(folder, manifest=""):
    folder.mkdir(parents=True)
    if manifest:
        (folder / "package.xml").write_text(
            f"<package><name>{manifest}</name></package>"
        )
    return folder


def test_package_is_not_found_where_there_is_none(nowhere):
    del nowhere
    assert Packages({}, None).folder("my_robot") is None


def test_given_folder_is_relative_to_the_file_and_comes_first(nowhere, monkeypatch):
    given = made(nowhere / "here" / "models")
    made(nowhere / "ros" / "my_robot", "my_robot")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(nowhere / "ros"))
    found = Packages({"my_robot": "models"}, nowhere / "here").folder("my_robot")
    assert found == given


def test_ros_package_is_found_by_the_name_in_its_manifest(nowhere, monkeypatch):
    there = made(nowhere / "ros" / "stack" / "folder", "my_robot")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/no/where:{nowhere / 'ros'}")
    assert Packages({}, nowhere).folder("my_robot") == there
    assert Packages({}, nowhere).folder("folder") is None


def test_ament_package_is_found_in_its_prefix(nowhere, monkeypatch):
    there = made(nowhere / "install" / "share" / "my_robot")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(nowhere / "install"))
    assert Packages({}, nowhere).folder("my_robot") == there


@pytest.mark.parametrize("inside", ["cmeel.prefix/share/my-robot", "my_robot"])
def test_installed_python_package_is_found_by_its_name(nowhere, monkeypatch, inside):
    there = made(nowhere / "site" / inside)
    (there / "__init__.py").write_text("raise AssertionError('imported')")
    monkeypatch.setattr(sys, "path", [*sys.path, str(nowhere / "site")])
    assert Packages({}, nowhere).folder("my-robot") == there


def test_what_robot_descriptions_has_loaded_is_found_and_nothing_loaded(nowhere):
    cache = nowhere / "home" / ".cache" / "robot_descriptions"
    there = made(cache / "somebodys_models" / "my_robot")
    assert Packages({}, nowhere).folder("my_robot") == there
    assert Packages({}, nowhere).folder("another") is None
    assert [x.name for x in cache.iterdir()] == ["somebodys_models"]


def test_uri_leads_into_its_package(nowhere):
    given = made(nowhere / "models")
    found = Packages({"my_robot": "models"}, nowhere)
    for uri in ("package://my_robot/a/b.stl", "package:///my_robot/a/b.stl"):
        assert found.path(uri, nowhere) == given / "a" / "b.stl"
    assert found.path("file:///x/y.stl", nowhere).as_posix() == "/x/y.stl"
    assert found.path("y.stl", nowhere) == nowhere / "y.stl"
    assert found.path("package://nosuch/y.stl", nowhere) is None


def test_names_are_read_from_a_text():
    text = '<mesh filename="package://b/x.stl"/> package:///a/y.stl, package://b/z'
    assert package_names(text) == ["a", "b"]


def test_given_folder_that_is_missing_is_refused(nowhere):
    with pytest.raises(ParameterError, match="must be a folder that is there"):
        Packages({"my_robot": "nowhere"}, nowhere).check()
