"""A live session: a scenario simulated in real time, with an operator at the stick."""

import dataclasses as dc
import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_mobman import signals
from drake_mobman.console.choices import choice_names, live_scenario
from drake_mobman.console.mailbox import Mailbox, OperatorInput
from drake_mobman.console.real_time import RealTimePacer
from drake_mobman.console.recordings import Recordings
from drake_mobman.console.snapshot import Snapshot, status_text
from drake_mobman.console.tracking_error import tracking_error
from drake_mobman.diagrams import make_diagram
from drake_mobman.robot_model import RobotModel
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.finite import check_finite, death
from drake_mobman.simulation.log import Log, drained_log
from drake_mobman.teleop.gate import Arming, GateStatus

_DRAIN_PERIOD = 0.25
"""Time between two writes of the log to disk [s]: a kill costs no more than that."""

_SNAPSHOT_PERIOD = 1 / 30
"""Time between two snapshots [s]."""


class LiveSession:
    """Simulates a scenario in a thread of its own, in real time, until it is closed.

    All methods may be called from any thread. The operator's input is sampled at the
    control ticks; the gate in the diagram decides whether it moves anything.

    Args:
        scenario: as `load_scenario` returns it. The operator replaces its source, and
            may choose every controller that works with it, if it names none.
        record: folder to record to; see `record`.

    Raises:
        ParameterError: where the scenario cannot be driven.
        FolderError: where the folder cannot take a recording.
    """

    def __init__(self, scenario: AnyScenario, record: Path | None = None) -> None:
        self.scenario = live_scenario(scenario)
        self.choices = choice_names(self.scenario)
        self._model = RobotModel(self.scenario.robot)
        self._diagram = make_diagram(self.scenario)
        # Names of all that a snapshot holds.
        self.signals = frozenset(port.get_name() for port in self._output_ports())
        # Indices of the bodies that an operator may drag, by name.
        draggable = signals.DRAG in self.signals
        self.draggable = self._model.arm_bodies if draggable else {}
        self._mailbox = Mailbox(max_latency=self.scenario.gate.fresh)
        self._stopped_by = "nobody"
        self._snapshot = Snapshot(choice=self.choices[0])
        self._tracking_error = 0.0
        self._recent: Log = {}  # The last two samples that were logged.
        # Requests of other threads; the loop checks them at each tick.
        self._closing = threading.Event()
        self._restart = threading.Event()
        self._recordings = Recordings(self.scenario)
        if record is not None:
            self.record(record)
        self._thread = threading.Thread(target=self._run, name="session", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # What operators and viewers do.

    def send(self, operator_input: OperatorInput, latency: float = 0.0) -> bool:
        """Takes the operator's input; returns whether it counts, or came too late.

        Args:
            operator_input: the operator's.
            latency: its largest possible latency [s].
        """
        return self._mailbox.put(operator_input, latency)

    def release(self) -> None:
        """Forgets the operator: the robot stops, and another may arm it."""
        self._mailbox.clear()

    def stop(self, who: str) -> None:
        """Stops the robot, whoever drives; `who` is shown, as "stopped by a viewer"."""
        self._stopped_by = who
        self._mailbox.stop()

    def choose(self, name: str) -> None:
        """Lets one of `choices` drive.

        Raises:
            ValueError: if it is none of them.
        """
        if name not in self.choices:
            valid = ", ".join(repr(choice) for choice in self.choices)
            raise ValueError(f"no choice {name!r}; valid names are {valid}")
        self._mailbox.choose(self.choices.index(name))

    def reset(self) -> None:
        """Starts over, disarmed; a recording goes on in a new folder."""
        self._restart.set()

    def record(self, folder: Path | None) -> None:
        """Starts over and records to `folder`; with None, ends the recording.

        A recording starts where the scenario starts, or it could not be played back.
        After a reset it goes to `folder`-2, `folder`-3 and so on, past what exists.

        Raises:
            FolderError: where the folder cannot take a recording, or has one already.
        """
        self._recordings.want(folder)  # Before the restart, which uses it.
        if folder is not None:
            self._restart.set()

    def snapshot(self) -> Snapshot:
        """Returns the session as it was at most a thirtieth of a second ago."""
        return self._snapshot

    def close(self, hurried: Callable[[], bool] = lambda: False) -> bool:
        """Ends the session, and waits until all recordings are complete run folders.

        Args:
            hurried: whether to stop waiting; the folders are completed anyway.

        Returns:
            Whether all are complete.
        """
        self._closing.set()
        self._thread.join()
        complete = self._recordings.close(hurried)
        self._update_snapshot(recording=None)
        return complete

    # The thread.

    def _run(self) -> None:
        while not self._closing.is_set():
            self._restart.clear()
            self._recordings.begin()
            died = self._simulate()
            # A dead simulation stays as it is until it is reset.
            while died and not (self._closing.is_set() or self._restart.is_set()):
                self._recordings.poll()
                self._update_snapshot()
                time.sleep(_SNAPSHOT_PERIOD)

    def _simulate(self) -> bool:
        """Simulates from the start until a restart or the end, or until it dies.

        Returns:
            Whether it died.
        """
        simulator = Simulator(self._diagram)
        context = simulator.get_mutable_context()
        operator_input = self._diagram.GetInputPort(signals.OPERATOR_INPUT)
        pacer = RealTimePacer(self.scenario.in_whole_steps().period)
        drained = shown = -math.inf
        self._recent = {}
        died = ""
        try:
            simulator.Initialize()
            while not (self._closing.is_set() or self._restart.is_set()):
                operator_input.FixValue(context, np.array(self._mailbox.sample()))
                simulator.AdvanceTo(pacer.next_time())
                check_finite(self._diagram, context)
                now = time.monotonic()
                if now - drained >= _DRAIN_PERIOD:
                    self._drain(context, pacer)
                    drained = now
                if now - shown >= _SNAPSHOT_PERIOD:
                    self._take_snapshot(context, pacer)
                    shown = now
                pacer.wait()
        except (Exception, SystemExit) as error:  # Drake's assertions are the latter.
            died = death(self._diagram, context, error)
        self._drain(context, pacer)
        self._recordings.end(pacer.wall_time(), died)
        if died:
            text = f"{died}; reset to start over"
            self._update_snapshot(died=died, text=text, recording=None)
        return bool(died)

    def _drain(self, context: Any, pacer: RealTimePacer) -> None:
        """Empties the log, to disk where it is recorded."""
        self._recordings.poll()
        log = drained_log(self._diagram, context)
        if not len(log["time"]):
            return
        self._recent = {
            name: np.concatenate([self._recent.get(name, x[:0]), x])[-2:]
            for name, x in log.items()
        }
        self._tracking_error = tracking_error(self.scenario, self._model, self._recent)
        self._recordings.append(log, pacer.wall_time())

    # Snapshots.

    def _output_ports(self) -> list[Any]:
        count = self._diagram.num_output_ports()
        return [self._diagram.get_output_port(i) for i in range(count)]

    def _take_snapshot(self, context: Any, pacer: RealTimePacer) -> None:
        values = {
            port.get_name(): tuple(port.Eval(context).tolist())
            for port in self._output_ports()
        }
        status = GateStatus(int(values[signals.GATE_STATUS][0]))
        arming = Arming(int(values[signals.GATE_ARMING][0]))
        _, chosen, _ = values.get(signals.HANDOVER, (0, 0, 1))
        self._snapshot = Snapshot(
            time=context.get_time(),
            signals=values,
            tracking_error=self._tracking_error,
            status=status,
            arming=arming,
            text=status_text(status, arming, self._stopped_by),
            choice=self.choices[int(chosen)],
            real_time_factor=pacer.factor(context.get_time()),
            recording=self._recordings.folder,
            problem=self._recordings.problem,
        )

    def _update_snapshot(self, **changes: Any) -> None:
        """Changes the last snapshot: a simulation that has stopped makes no new one."""
        problem = self._recordings.problem
        self._snapshot = dc.replace(self._snapshot, problem=problem, **changes)
