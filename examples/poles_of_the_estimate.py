"""Shows that feeding back how the base moves leaves the loop stable: by its poles.

    python examples/poles_of_the_estimate.py [FILE.png]

The exact law on the planar robot drives the end effector round a bend, steadily, with
the base carrying it; its drive is late and lags, and its wheels are larger than it
knows. The whole loop, decomposer to drive and back, is linearized there by AutoDiffXd:
of x_{k+1} = f(x_k) the poles are the eigenvalues of df/dx. All that are neither 0 nor
an integrator's 1 are shown, for an estimate by what is sent, by what is measured, and
by what is measured late.
"""

import sys
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from drake_mobman.diagrams.wiring import connect_by_name, outputs
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

import drake_mobman as mm
from drake_mobman import signals

PERIOD = 0.01
PUSH = 0.2, 0.3, 0.0  # v_c [m/s], omega_c [rad/s], v_z [m/s].
TIME = 60.0  # Until all is steady [s].
DELAY, BANDWIDTH = 5, 5.0  # Of the drive [periods], [Hz].
SIZE = 1.03  # Of its wheels, over what it knows.
LATE = 2  # The measurement, where it is [periods].

ESTIMATES = {
    "sent": mm.Sent(),
    "measured": mm.Measured(),
    "measured late": mm.Measured(latency=LATE * PERIOD),
    "measured late, drive known": mm.Measured(
        latency=LATE * PERIOD, delay=DELAY * PERIOD, bandwidth=BANDWIDTH
    ),
}


@mm.scalar_block
class Drive(LeafSystem):
    """A drive with a delay and a lag. The state: commands sent, then velocities."""

    def __init__(self, late: int) -> None:
        self.late = late
        self.sent = self.DeclareVectorInputPort("sent", 2)
        needs = {self.xd_ticket()}
        for name, size, calc in (
            (signals.BASE_COMMAND_SMOOTHED, 2, self._calc_driven),
            (signals.BASE_MEASURED, 3, self._calc_measured),
        ):
            self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=needs)
        self.DeclareDiscreteState(2 * (DELAY + 1 + late))
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._drive)

    def _rows(self, context: Any) -> Any:
        return context.get_discrete_state_vector().CopyToVector().reshape(-1, 2)

    def _calc_driven(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._rows(context)[DELAY])

    def _calc_measured(self, context: Any, output: Any) -> None:
        v, omega = self._rows(context)[DELAY + self.late]
        output.SetFromVector(np.array([v, 0.0 * v, omega]))

    def _drive(self, context: Any, state: Any) -> None:
        rows, sent = self._rows(context), self.sent.Eval(context)
        pole = np.exp(-2 * np.pi * BANDWIDTH * PERIOD)
        now = pole * rows[DELAY] + (1 - pole) * SIZE * rows[0]
        after = [*rows[1:DELAY], sent, now, *rows[DELAY : DELAY + self.late]]
        state.get_mutable_vector().SetFromVector(np.concatenate(after))


def make_loop(estimate: Any) -> Diagram:
    """Returns the loop, with an estimate of how the base moves."""
    setup = mm.RobotSetup.of(mm.Planar(), PERIOD, base_limits=mm.Smoother().limits())
    start = [0.0, 0.0, 0.0, *setup.arm.inverse((1.4, 0.0, 0.0))]
    builder = DiagramBuilder()
    blocks = {
        "decomposer": mm.Exact().build(setup),
        "smoother": mm.Smoother().build(setup),
        "estimator": estimate.build(PERIOD),
        "arm": mm.ClosedFormInverse(setup.arm, setup.joint_limits, PERIOD),
        "robot": mm.Kinematic().build(setup, start),
    }
    systems = [builder.AddNamedSystem(*block) for block in blocks.items()]
    late = round(getattr(estimate, "latency", 0.0) / PERIOD)
    drive = builder.AddNamedSystem("drive", Drive(late))
    push = builder.AddSystem(ConstantVectorSource(PUSH))
    ports = outputs([*systems, push]) | {
        signals.EE_COMMAND: push.get_output_port(),
        signals.BASE_MEASURED: drive.GetOutputPort(signals.BASE_MEASURED),
    }
    builder.Connect(ports[signals.BASE_COMMAND_SMOOTHED], drive.get_input_port())
    connect_by_name(builder, ports, systems[:-1])
    driven = drive.GetOutputPort(signals.BASE_COMMAND_SMOOTHED)
    connect_by_name(
        builder, ports | {signals.BASE_COMMAND_SMOOTHED: driven}, systems[-1:]
    )
    return builder.Build()


def poles(estimate: Any) -> np.ndarray:
    """Returns the loop's poles but for zeros and integrators, the slowest first."""
    loop = make_loop(estimate)
    simulator = Simulator(loop)
    simulator.AdvanceTo(TIME)
    state = simulator.get_context().get_discrete_state()
    steady = [state.get_vector(i).CopyToVector() for i in range(state.num_groups())]
    slopes = InitializeAutoDiff(np.concatenate(steady)).ravel()
    other = loop.ToAutoDiffXd()
    context, first = other.CreateDefaultContext(), 0
    for i, part in enumerate(steady):
        context.SetDiscreteState(i, slopes[first : first + len(part)])
        first += len(part)
    after = other.EvalUniquePeriodicDiscreteUpdate(context)
    found = [after.get_vector(i).CopyToVector() for i in range(after.num_groups())]
    A = ExtractGradient(np.concatenate(found).reshape(-1, 1))
    values = np.linalg.eigvals(A)
    size = np.abs(values)
    kept = values[(size > 1e-3) & (np.abs(values - 1) > 1e-9)]
    return kept[np.argsort(-np.abs(kept))]


def draw(found: dict[str, np.ndarray], file: str) -> None:
    """Draws poles in the plane of z."""
    figure, axes = plt.subplots(figsize=(5.5, 5.0), layout="constrained")
    axes.add_patch(plt.Circle((0, 0), 1.0, fill=False, color="0.6"))
    for (name, values), mark in zip(found.items(), "ox+1", strict=True):
        axes.plot(values.real, values.imag, mark, fillstyle="none", label=name)
    axes.set(xlabel="Re z", ylabel="Im z", title="Poles of the loop", aspect="equal")
    axes.legend(loc="lower left", fontsize="small")
    figure.savefig(file, dpi=150)


def main(file: str = "") -> None:
    """Prints the slowest poles, and draws all to a file, if one is named."""
    found = {name: poles(estimate) for name, estimate in ESTIMATES.items()}
    for name, values in found.items():
        slowest = ", ".join(f"{value:.4f}" for value in values[:4])
        print(f"{name:28s}largest {abs(values[0]):.4f}   {slowest}")
    if file:
        draw(found, file)


if __name__ == "__main__":
    main(*sys.argv[1:])
