"""A live session: a scenario simulated in real time, with an operator at the stick.

Teleoperation with the operator in the loop: commands are sampled at the control ticks.
"""

import collections
import dataclasses as dc
import itertools
import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.console.choices import choices, live
from drake_mobman.console.finisher import Finisher
from drake_mobman.console.mailbox import Mailbox, OperatorInput
from drake_mobman.console.recorder import Recorder, check_recordable
from drake_mobman.diagrams import make_diagram
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import AnyScenario, Guided
from drake_mobman.simulation.finite import check_finite, death
from drake_mobman.simulation.log import Log, drained_log
from drake_mobman.simulation.output_folder import FolderError
from drake_mobman.simulation.simulate import Run
from drake_mobman.teleop.gate import Arming, GateStatus

WHY = {
    GateStatus.OK: "driving",
    GateStatus.NOT_FINITE: "stopped: the command was not finite",
    GateStatus.OVER_RANGE: "stopped: the command was over its range",
    GateStatus.NOT_ARMED: "not armed yet",
    GateStatus.RELEASED: "stopped: the dead-man was let go",
    GateStatus.STALE: "stopped: the operator was not heard in time",
    GateStatus.STOPPED: "stopped by {who}",
    GateStatus.GONE: "stopped: the operator has gone",
}
"""What the gate's status says to people."""

NEXT = {
    Arming.LATCHED: "; let stick and dead-man go",
    Arming.READY: "; press the dead-man to drive",
    Arming.ARMED: "",
}
"""What is to be done next."""

_DRAIN = 0.25
"""Between two times that the log goes to disk [s]: a kill costs no more than that."""

_SHOW = 1 / 30
"""Between two snapshots [s]."""

_LAG = 0.1
"""How far the simulation may fall behind [s] and still catch up. What is more is left
out: commands are never executed faster than they were given."""


@dc.dataclass(frozen=True)
class Snapshot:
    """A session at one time; nothing in it changes any more."""

    time: float = 0.0  # Simulated [s].
    # Every logged signal under its name; see `drake_mobman.signals`.
    signals: dict[str, tuple[float, ...]] = dc.field(default_factory=dict)
    hand_error: float = 0.0  # As in the metrics: [m/s]; where a hand pulls, [m].
    status: GateStatus = GateStatus.NOT_ARMED
    arming: Arming = Arming.LATCHED
    text: str = ""  # Status, reason and what to do next, in one line.
    choice: str = ""  # Who drives, or is about to.
    real_time_ratio: float = 1.0  # Simulated over wall time, of the last second.
    recording: Path | None = None  # Folder, while it is written to.
    problem: str = ""  # What went wrong with the recording, in one line.
    died: str = ""  # When and why the simulation ended, in one line.


class LiveSession:
    """Simulates a scenario in a thread of its own, in real time, until it is closed.

    All methods may be called from any thread. What the operator says is taken in at the
    control ticks; whether it moves anything is decided by the gate in the diagram.

    Args:
        scenario: as `load_scenario` returns it. Its source gives way to the operator,
            who may choose all decomposers that work with it, if it names none.
        record: folder to record to; see `record`.

    Raises:
        ParameterError: where the scenario cannot be driven.
        FolderError: where the folder cannot take a recording.
    """

    def __init__(self, scenario: AnyScenario, record: Path | None = None) -> None:
        self.scenario = live(scenario)
        self.choices = choices(self.scenario)
        # Indices of the bodies that an operator may drag, by name.
        pulled = isinstance(self.scenario, Guided)
        robot = self.scenario.robot
        self._model = RobotModel(robot)
        self.draggable = self._model.arm_bodies if pulled else {}
        self._diagram = make_diagram(self.scenario)
        self._inbox = Mailbox(late=self.scenario.gate.fresh)
        self._who = "nobody"
        self._snapshot = Snapshot(choice=self.choices[0])
        self._hand_error = 0.0
        self._recent: Log = {}  # The last two samples that were logged.
        # What other threads want; the loop looks at each tick.
        self._closing = threading.Event()
        self._restart = threading.Event()
        self._record_to: Path | None = None
        # Of recordings.
        self._recorder: Recorder | None = None
        self._taken: set[Path] = set()
        self._finisher = Finisher()
        self._problem = ""  # Of the latest.
        if record is not None:
            self.record(record)
        self._thread = threading.Thread(target=self._run, name="session", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # What people do.

    def tell(self, said: OperatorInput, lateness: float = 0.0) -> bool:
        """Takes the operator's word; returns whether it counts, or came too late.

        Args:
            said: by the operator.
            lateness: how long ago that may have been, at most [s].
        """
        return self._inbox.tell(said, lateness)

    def hand_over(self) -> None:
        """Forgets the operator: the robot stops, and another may arm it."""
        self._inbox.forget()

    def stop(self, who: str) -> None:
        """Stops the robot, whoever drives; `who` says by whom, as in "a viewer"."""
        self._who = who
        self._inbox.stop()

    def choose(self, name: str) -> None:
        """Lets one of `choices` drive.

        Raises:
            ValueError: if it is none of them.
        """
        if name not in self.choices:
            valid = ", ".join(repr(choice) for choice in self.choices)
            raise ValueError(f"no choice {name!r}; valid names are {valid}")
        self._inbox.choose(self.choices.index(name))

    def reset(self) -> None:
        """Starts over, disarmed; what is recorded goes on in a folder of its own."""
        self._restart.set()

    def record(self, folder: Path | None) -> None:
        """Starts over and records to `folder`; with None, ends the recording.

        A recording starts where the scenario starts, or it could not be played back.
        Those after a reset go to `folder`-2, `folder`-3 and so on, past what exists.

        Raises:
            FolderError: where the folder cannot take a recording, or has one already.
        """
        if folder is None:
            self._record_to = None
            return
        try:
            folder = folder.resolve()
            check_recordable(self._free(folder))
        except FolderError:
            raise
        except (OSError, RuntimeError) as error:  # The latter of links in a circle.
            why = getattr(error, "strerror", None) or error
            raise FolderError(f"{folder}: cannot be written, {why}") from None
        self._record_to = folder  # Before the restart, which looks at it.
        self._restart.set()

    def snapshot(self) -> Snapshot:
        """Returns the session as it was at most a thirtieth of a second ago."""
        return self._snapshot

    def close(self, hurried: Callable[[], bool] = lambda: False) -> bool:
        """Ends the session, and waits until all recordings are complete run folders.

        Args:
            hurried: whether not to wait for that any more; it goes on all the same.

        Returns:
            Whether all are.
        """
        self._closing.set()
        self._thread.join()
        while self._finisher.works and not hurried():
            time.sleep(_SHOW)
            self._finisher.hear()
        done = not self._finisher.works
        self._finisher.leave()
        self._snapshot = dc.replace(
            self._snapshot, recording=None, problem=self._problems()
        )
        return done

    # The thread.

    def _run(self) -> None:
        while not self._closing.is_set():
            self._restart.clear()
            self._begin_recording()
            died = self._drive()
            # One that died stands until it is started over.
            while died and not (self._closing.is_set() or self._restart.is_set()):
                self._finisher.hear()
                self._snapshot = dc.replace(self._snapshot, problem=self._problems())
                time.sleep(_SHOW)

    def _drive(self) -> bool:
        """Drives from the start until something else is wanted, or it dies.

        Returns:
            Whether it died.
        """
        simulator = Simulator(self._diagram)
        context = simulator.get_mutable_context()
        said = self._diagram.GetInputPort(signals.OPERATOR_INPUT)
        pace = _Pace(self.scenario.in_whole_steps().period)
        drained = shown = -math.inf
        self._recent = {}
        died = ""
        try:
            simulator.Initialize()
            while not (self._closing.is_set() or self._restart.is_set()):
                said.FixValue(context, np.array(self._inbox.sample()))
                simulator.AdvanceTo(pace.next_time())
                check_finite(self._diagram, context)
                now = time.monotonic()
                if now - drained >= _DRAIN:
                    self._drain(context, pace)
                    drained = now
                if now - shown >= _SHOW:
                    self._show(context, pace)
                    shown = now
                pace.wait()
        except (Exception, SystemExit) as error:  # Drake's assertions are the latter.
            died = death(self._diagram, context, error)
        self._drain(context, pace)
        self._end_recording(pace, died)
        if died:
            text = f"{died}; reset to start over"
            self._snapshot = dc.replace(
                self._snapshot, died=died, text=text, recording=None
            )
        return bool(died)

    def _show(self, context: Any, pace: "_Pace") -> None:
        """Makes a new snapshot."""
        ports = map(
            self._diagram.get_output_port, range(self._diagram.num_output_ports())
        )
        values = {port.get_name(): tuple(port.Eval(context).tolist()) for port in ports}
        status = GateStatus(int(values[signals.GATE_STATUS][0]))
        arming = Arming(int(values[signals.GATE_ARMING][0]))
        _, chosen, _ = values.get(signals.HANDOVER, (0, 0, 1))
        self._snapshot = Snapshot(
            time=context.get_time(),
            signals=values,
            hand_error=self._hand_error,
            status=status,
            arming=arming,
            text=WHY[status].format(who=self._who) + NEXT[arming],
            choice=self.choices[int(chosen)],
            real_time_ratio=pace.ratio(context.get_time()),
            recording=self._recorder.folder if self._recorder else None,
            problem=self._problems(),
        )

    # The recording.

    def _free(self, folder: Path) -> Path:
        """Returns `folder`, or the first of folder-2, -3 ... once it is recorded to."""
        if folder not in self._taken:
            return folder
        numbered = (folder.with_name(f"{folder.name}-{n}") for n in itertools.count(2))
        # One that is being finished may not exist for a moment.
        return next(x for x in numbered if x not in self._taken and not x.exists())

    def _begin_recording(self) -> None:
        if self._record_to is None:
            return
        try:
            folder = self._free(self._record_to)
            self._recorder = Recorder(self.scenario, folder)
        except OSError as error:
            self._problem = f"not recorded: {error}"
            return
        self._taken.add(folder)
        self._problem = ""

    def _drain(self, context: Any, pace: "_Pace") -> None:
        """Empties the log, to disk where it is recorded."""
        self._finisher.hear()
        log = drained_log(self._diagram, context)
        if not len(log["time"]):
            return
        self._recent = {
            name: np.concatenate([self._recent.get(name, x[:0]), x])[-2:]
            for name, x in log.items()
        }
        self._hand_error = hand_error(self.scenario, self._model, self._recent)
        if self._recorder is None:
            return
        try:
            self._recorder.append(log)
        except OSError as error:
            self._problem = f"recording ended: {error}"
            self._record_to = None
        if self._record_to is None:
            self._end_recording(pace, "")

    def _end_recording(self, pace: "_Pace", died: str) -> None:
        """Ends a recording; another process completes its folder, out of our way."""
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        if not recorder.plays:  # Started over at once.
            recorder.drop()
            self._taken.discard(recorder.folder)
            return
        recorder.close()
        self._finisher.give(recorder.folder, pace.wall_time(), died)

    def _problems(self) -> str:
        """Returns what went wrong with the recordings, in one line."""
        return "; ".join(filter(None, [self._problem, *self._finisher.failed]))


def hand_error(scenario: AnyScenario, model: RobotModel, log: Log) -> float:
    """Returns how far the hand is from its command, at a log's last sample.

    As in the metrics: its velocity in the plane [m/s]; where a hand pulls, the distance
    of the tool from the hand [m], and not a number where that drags something else.

    Args:
        scenario: of the session.
        model: of its robot.
        log: of two samples, as with masses the command of the one before counts; of
            one, at the start alone.
    """
    if signals.HAND_POSITION in log:
        if log[signals.DRAG][-1].any():
            return math.nan
        gap = log[signals.HAND_POSITION][-1] - log[signals.TOOL_POSITION][-1]
    else:
        gap = ee_motion(Run(scenario, log, 0.0, np.zeros(0)), model).error[-1]
    return float(np.linalg.norm(gap))


class _Pace:
    """Keeps the control ticks to the wall clock, and knows how well that goes."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._ticks = 0
        self._start = self._anchor = time.monotonic()
        self._shown = collections.deque([(self._start, 0.0)])  # Wall and simulated.

    def next_time(self) -> float:
        """Returns the simulated time of the next tick [s]."""
        self._ticks += 1
        return self._ticks * self._period

    def wait(self) -> None:
        """Waits for the next tick."""
        due = self._anchor + self._ticks * self._period
        ahead = due - time.monotonic()
        if ahead > 0:
            time.sleep(ahead)
        late = time.monotonic() - due
        if late > _LAG:
            self._anchor += late

    def wall_time(self) -> float:
        """Returns for how long it has gone [s]."""
        return time.monotonic() - self._start

    def ratio(self, time_: float) -> float:
        """Returns simulated over wall time of the last second; call it now and then."""
        now = time.monotonic()
        self._shown.append((now, time_))
        while self._shown[1][0] < now - 1.0:
            self._shown.popleft()
        then, time_then = self._shown[0]
        return (time_ - time_then) / (now - then)
