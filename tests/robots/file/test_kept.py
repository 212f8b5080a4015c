"""A run of a robot from a file can be run again, from its folder alone."""

import shutil
import warnings

import numpy as np
import pytest

from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.output_folder import OutputFolder
from drake_mobman.simulation.run_folder import RUN, write_log
from drake_mobman.simulation.simulate import simulate


@pytest.fixture
def written(folder):
    """A run, and the folder that it was written to."""
    folder.write(
        "drive.yaml",
        """\
        duration: 0.2
        robot: !File {path: small.robot.yaml}
        source: !Script {segments: [!Held {duration: 0.2, v_c: 0.2, omega_c: 0.2}]}
        """,
    )
    run = simulate(load_scenario(folder.path / "drive.yaml"))
    out = folder.path / "elsewhere" / "run"
    with OutputFolder(out, RUN) as place:
        write_log(run, place)
    return run, out


def test_it_runs_again_from_its_folder_bit_for_bit(folder, written):
    run, out = written
    (folder.path / "small.robot.yaml").unlink()
    moved = folder.path / "moved"
    shutil.move(out, moved)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = simulate(load_scenario(moved / "scenario.yaml"))
    assert list(again.log) == list(run.log)
    for name in run.log:
        np.testing.assert_array_equal(again.log[name], run.log[name])


def test_scenario_in_it_names_no_place_on_this_machine(folder, written):
    _, out = written
    assert str(folder.path) not in (out / "scenario.yaml").read_text()
    assert "path: robot.robot.yaml" in (out / "scenario.yaml").read_text()


def test_model_that_has_changed_since_is_told_in_one_line(folder, written):
    _, out = written
    folder.change("small.urdf", 'mass value="20.0"', 'mass value="21.0"')
    with pytest.warns(
        UserWarning, match=r"robot.yaml: changed since this run was"
    ) as w:
        load_scenario(out / "scenario.yaml")
    (line,) = [str(x.message) for x in w]
    assert str(folder.path / "small.urdf") in line
    assert line.isprintable()
