"""A session played back: to the bit, from a file that may be cut off anywhere."""

import dataclasses as dc

import numpy as np
import pytest
from drake_mobman.diagrams import make_diagram
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import VectorLogSink

from drake_mobman.console.choices import live_scenario
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import Guided, ScenarioError, load_scenario
from drake_mobman.schema import dump_typed
from drake_mobman.simulation.log import read_log
from drake_mobman.simulation.output_folder import FolderError, OutputFolder
from drake_mobman.simulation.run_folder import RUN, check_run_folder, write_log
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.drag import Dragged
from drake_mobman.teleop.live import NOBODY, SIZE, LiveSource, OperatorSample
from drake_mobman.teleop.recorded import (
    COMMANDS,
    RecordedSource,
    Recording,
    header,
    read_samples,
    write_samples,
)

PERIOD = 0.01

HEADER = header(PERIOD)


def record(folder, samples):
    """Writes samples as a session does, and returns the file."""
    file = folder / COMMANDS
    with file.open("wb") as out:
        out.write(HEADER)
        write_samples(out, samples)
    return file


def anything(rows, seed=0):
    """Returns samples (rows, SIZE) with all that a device may say."""
    rng = np.random.default_rng(seed)
    samples = rng.normal(size=(rows, SIZE))
    odd = [np.nan, -np.nan, np.inf, -np.inf, -0.0, 5e-324, 1e308]
    spots = rng.random(samples.shape) < 0.2
    samples[spots] = rng.choice(odd, spots.sum())
    return samples


# --- The file ------------------------------------------------------------------------


def test_samples_come_back_bit_for_bit(tmp_path):
    samples = anything(50)
    assert read_samples(record(tmp_path, samples)).tobytes() == samples.tobytes()


def test_samples_may_be_appended_a_few_at_a_time(tmp_path):
    samples = anything(50)
    file = record(tmp_path, samples[:10])
    for some in np.split(samples[10:], 8):
        with file.open("ab") as out:
            write_samples(out, some)
    assert read_samples(file).tobytes() == samples.tobytes()


@pytest.mark.parametrize("cut", [1, 8, 8 * SIZE - 1])
def test_a_file_that_is_cut_off_is_read_as_far_as_it_is_whole(tmp_path, cut):
    samples = anything(5)
    file = record(tmp_path, samples)
    file.write_bytes(file.read_bytes()[:-cut])
    assert read_samples(file).tobytes() == samples[:4].tobytes()


def test_a_file_from_before_anything_could_be_dragged_is_still_read(tmp_path):
    names = b"v_c, omega_c, v_z, dead_man, age, stop, choice"
    samples = anything(5)[:, :7]
    file = tmp_path / COMMANDS
    file.write_bytes(b"operator_input: " + names + b"; <f8\n" + samples.tobytes())
    read = read_samples(file)
    assert read[:, :7].tobytes() == samples.tobytes()
    assert read.shape == (5, 14)
    assert not read[:, 7:].any()


@pytest.mark.parametrize("period", [b"abc", b"", b"1..0", b"nan"])
def test_a_file_with_a_period_that_is_none_is_refused(tmp_path, period):
    file = record(tmp_path, anything(5))
    file.write_bytes(file.read_bytes().replace(b"period 0.01", b"period " + period))
    with pytest.raises(ParameterError, match=r"^file: .*must be a recorded session"):
        Recording(str(file)).samples(PERIOD)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (None, "cannot be read, No such file or directory; must be a recorded session"),
        (b"", "must be a recorded session"),
        (b"PK\x03\x04", "must be a recorded session"),
        (HEADER, "must be a recorded session of one period or more"),
        (HEADER + bytes(8 * SIZE), "must be a recorded session of one period or more"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, data, why):
    file = tmp_path / COMMANDS
    if data is not None:
        file.write_bytes(data)
    with pytest.raises(ParameterError) as error:
        read_samples(file)
    assert str(error.value).startswith("file: ")
    assert error.value.valid == why


# --- The block -----------------------------------------------------------------------


def test_played_back_it_says_at_every_time_what_was_said_live():
    # Not at the ticks alone: a plant of shorter steps looks between them.
    said = anything(20)
    builder = DiagramBuilder()
    source = builder.AddSystem(LiveSource(PERIOD))
    builder.ExportInput(source.get_input_port(), "operator_input")
    fine = builder.AddSystem(VectorLogSink(SIZE, PERIOD / 4))
    builder.Connect(source.get_output_port(), fine.get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    for k, sample in enumerate(said):
        diagram.get_input_port().FixValue(context, sample)
        simulator.AdvanceTo((k + 1) * PERIOD)
    live_log = fine.FindLog(context)
    at_ticks = live_log.data().T[::4]
    np.testing.assert_array_equal(at_ticks[0], NOBODY)
    np.testing.assert_array_equal(at_ticks[1:], said)

    builder = DiagramBuilder()
    source = builder.AddSystem(RecordedSource(at_ticks, PERIOD))
    again = builder.AddSystem(VectorLogSink(SIZE, PERIOD / 4))
    builder.Connect(source.get_output_port(), again.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(20 * PERIOD)
    log = again.FindLog(simulator.get_context())
    assert log.data().tobytes() == live_log.data().tobytes()
    simulator.AdvanceTo(21.5 * PERIOD)
    log = again.FindLog(simulator.get_context())
    np.testing.assert_array_equal(log.data()[:, -1], NOBODY)


# --- In a scenario -------------------------------------------------------------------


def written(folder, scenario, samples, **changes):
    """Writes a scenario that plays back samples, and returns its path."""
    record(folder, samples)
    played = dc.replace(scenario, source=Recording(), **changes)
    path = folder / "scenario.yaml"
    path.write_text(dump_typed(played))
    return str(path)


def operated(rng, ticks, choices, bodies):
    """Returns samples of someone who drives, lets go, falls silent and makes errors.

    And drags, where there are bodies to be dragged.
    """
    samples = []
    while len(samples) < ticks:
        for held in (0.0, 1.0):
            command = rng.uniform(-0.4, 0.4, 3) * held
            choice = float(rng.integers(0, choices))
            drag = OperatorSample().dragged
            if bodies and held and rng.random() < 0.5:
                point, to = rng.uniform(-0.1, 0.1, 3), rng.uniform(0.2, 0.8, 3)
                drag = Dragged(float(rng.choice(bodies)), *point, *to)
            n = int(rng.integers(3, 60) if held else rng.integers(1, 15))
            for _ in range(n):
                command = np.clip(command + rng.normal(0, 0.01, 3) * held, -0.4, 0.4)
                age = rng.uniform(0.0, 0.26 if rng.random() < 0.03 else 0.1)
                stop = float(rng.random() < 0.005)
                samples.append([*command, held, age, stop, choice, *drag])
        if rng.random() < 0.3:
            samples[-1][int(rng.integers(0, 3))] = rng.choice([np.nan, np.inf, 9.0])
    return np.array(samples[:ticks])


@pytest.mark.parametrize(
    "name", ["kwon_arbitrary", "kwon_spatial", "petric_teleop", "petric_guided"]
)
def test_what_was_driven_live_is_played_back_bit_for_bit(name, tmp_path):
    scenario = live_scenario(load_scenario(name))
    diagram = make_diagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    rng = np.random.default_rng(3)
    guided = isinstance(scenario, Guided)
    bodies = list(RobotModel(scenario.robot).arm_bodies.values()) if guided else []
    said = operated(rng, 300, len(scenario.controllers), bodies)
    for k, sample in enumerate(said):
        diagram.GetInputPort("operator_input").FixValue(context, sample)
        simulator.AdvanceTo((k + 1) * scenario.period)
    log = read_log(diagram, context)
    # There is something to play back: it moved, for more reasons than one it did not.
    assert np.abs(log["arm_velocity"]).max() > 0.05
    assert len(np.unique(log["gate_status"])) > 3
    assert len(np.unique(log["handover"][:, 1])) > 1
    assert not guided or len(np.unique(log["drag"][:, 0])) > 2

    path = written(tmp_path, scenario, log["operator_input"])
    run = simulate(load_scenario(path))
    assert run.died == ""
    assert run.log.keys() == log.keys()
    for signal, values in log.items():
        assert run.log[signal].tobytes() == values.tobytes(), signal


def test_a_replays_folder_plays_back_by_itself_wherever_it_goes(tmp_path):
    (tmp_path / "me").mkdir()
    said = operated(np.random.default_rng(5), 60, 1, [])
    given = written(tmp_path / "me", load_scenario("kwon_1"), said)

    def replayed(path, folder):
        run = simulate(load_scenario(str(path)))
        with OutputFolder(folder, RUN) as place:
            write_log(run, place)
        return run.log

    first = replayed(given, tmp_path / "a" / "me")
    (tmp_path / "me").rename(tmp_path / "gone")
    (tmp_path / "a").rename(tmp_path / "moved")
    copy = tmp_path / "moved" / "me"
    again = replayed(copy / "scenario.yaml", tmp_path / "again")
    # But not into its own folder, where it would go if nobody said otherwise.
    with pytest.raises(FolderError, match="it holds a recorded session"):
        check_run_folder(copy)
    assert first["operator_input"].tobytes() == said.tobytes()
    for signal, values in first.items():
        assert again[signal].tobytes() == values.tobytes(), signal


def test_recording_is_found_beside_its_scenario(tmp_path, monkeypatch):
    (tmp_path / "session").mkdir()
    kwon = load_scenario("kwon_1")
    path = written(tmp_path / "session", kwon, anything(5), duration=90.0)
    monkeypatch.chdir(tmp_path / "session")
    scenario = load_scenario("scenario.yaml")
    monkeypatch.chdir("/")
    assert scenario.source.samples(PERIOD).shape == (5, SIZE)
    assert scenario.name == "session"
    assert load_scenario(path) == scenario


def test_run_lasts_as_long_as_the_recording_or_shorter_if_asked(tmp_path):
    path = written(tmp_path, load_scenario("kwon_1"), anything(5), duration=90.0)
    assert load_scenario(path).duration == 4 * PERIOD
    assert load_scenario(path, ["duration=0.02"]).duration == 0.02


OLD = HEADER.partition(b"; period")[0] + b"\n"
"""First line of a file of before it told its period."""


@pytest.mark.parametrize("first", [HEADER, OLD], ids=["header", "scenario beside it"])
def test_recording_is_refused_at_another_period(tmp_path, first):
    path = written(tmp_path, load_scenario("kwon_1"), anything(5), duration=90.0)
    file = tmp_path / COMMANDS
    file.write_bytes(first + anything(5).tobytes())
    assert load_scenario(path).duration == 4 * PERIOD
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(path, ["period=0.02"])
    told = str(refusal.value)
    assert told.startswith("scenario.yaml with --set: source.file: '")
    assert told.endswith(
        "must be played back at its own period of 0.01 s, not at 0.02 s"
    )
    # From Python, too.
    played = dc.replace(load_scenario(path), period=0.02)
    with pytest.raises(ParameterError, match=r"own period of 0\.01 s, not at 0\.02 s$"):
        make_diagram(played)


def test_old_recording_alone_is_played_back_at_any_period(tmp_path):
    file = tmp_path / "old.bin"
    file.write_bytes(OLD + anything(5).tobytes())
    override = f"source=!Recording {{file: {file}}}"
    for period in (0.01, 0.02):
        scenario = load_scenario("kwon_1", [override, f"period={period}"])
        assert scenario.duration == 4 * period


def test_scenario_without_its_recording_is_refused_in_a_line(tmp_path):
    path = written(tmp_path, load_scenario("kwon_1"), anything(5))
    (tmp_path / COMMANDS).unlink()
    with pytest.raises(ScenarioError, match=r"^scenario.yaml: source\.file: .*No such"):
        load_scenario(path)


def test_operator_who_is_not_there_moves_nothing():
    log = simulate(load_scenario("kwon_1", ["source=operator", "duration=0.5"])).log
    assert not log["ee_command"].any()
    assert len(log["time"]) == 51
