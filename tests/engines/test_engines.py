"""A scenario in a second engine: the same blocks, the same motion, another plant."""

import dataclasses as dc

import numpy as np
import pytest

from drake_mobman.analysis.motion import ee_motion
from drake_mobman.engines import Drake, Mujoco
from drake_mobman.engines.mujoco import params
from drake_mobman.scenario import ScenarioError, load_scenario
from drake_mobman.schema import dump_typed
from drake_mobman.simulation.simulate import simulate

SAME = 1e-5
"""[m], [m/s], [rad], [rad/s]: of a run of 1.5 s in two engines. Their steps agree to
1e-8, but a free arm and the hand that holds it swing."""

SHORTER_STEPS = 2e-3
"""The same, where MuJoCo takes four steps in one of Drake's: it starts from rest, and
turns, that much sooner."""


def run_in(engine, name, *overrides):
    scenario = load_scenario(name, overrides)
    return simulate(dc.replace(scenario, engine=engine))


@pytest.mark.parametrize("name", ["kwon_franka", "petric_guided"])
def test_a_run_is_the_same_in_both_engines_at_the_same_step(name):
    engines = Drake(), Mujoco(substeps=1)
    drake, mujoco = (run_in(engine, name, "duration=1.5") for engine in engines)
    assert not mujoco.died
    assert np.ptp(drake["arm_position"], axis=0).max() > 0.02
    for signal in ("base_pose", "arm_position", "arm_velocity", "base_velocity"):
        assert mujoco[signal] == pytest.approx(drake[signal], abs=SAME), signal


def test_the_end_effector_follows_its_command_in_mujoco_too():
    run = run_in(Mujoco(), "kwon_franka", "duration=3")
    drake = run_in(Drake(), "kwon_franka", "duration=3")
    error = np.linalg.norm(ee_motion(run).error, axis=1)
    assert np.sqrt(np.mean(error**2)) < 5e-4
    assert run["base_pose"] == pytest.approx(drake["base_pose"], abs=SHORTER_STEPS)


def test_two_runs_in_mujoco_are_the_same_bit_for_bit():
    one, other = (run_in(Mujoco(), "kwon_franka", "duration=0.5") for _ in range(2))
    for signal in one.signals:
        assert np.array_equal(one[signal], other[signal]), signal


def test_mujoco_needs_masses():
    with pytest.raises(ScenarioError, match="needs a fidelity with masses") as error:
        load_scenario("kwon_1", ["engine=mujoco"])
    assert "\n" not in str(error.value)


def test_without_mujoco_one_line_says_which_extra_brings_it(monkeypatch):
    monkeypatch.setattr(params, "find_spec", lambda _: None)
    with pytest.raises(ScenarioError) as error:
        load_scenario("kwon_franka", ["engine=mujoco"])
    assert str(error.value) == (
        "kwon_franka.yaml with --set: engine: '!Mujoco' is not valid; "
        "needs MuJoCo: pip install 'drake_mobman[mujoco]'"
    )


def test_a_scenario_keeps_its_engine_in_its_run_folder(tmp_path):
    scenario = load_scenario("kwon_franka", ["engine=!Mujoco {substeps: 3}"])
    file = tmp_path / "scenario.yaml"
    file.write_text(dump_typed(scenario))
    assert load_scenario(file).engine == Mujoco(substeps=3)
