"""What is measured on wheels: by encoders, by a gyroscope, and from outside."""

import dataclasses as dc
from typing import Any

import numpy as np
from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import Adder, Demultiplexer, LinearSystem
from pydrake.systems.sensors import RotaryEncoders

from drake_mobman.parameters import Range, check_whole, within
from drake_mobman.robots.wheels.drive import delayed


@dc.dataclass
class Sensors:
    """Faults of the sensors. By default they measure what is true."""

    # Of the wheels [counts a turn]; rates are then differences over a tick. 0: exact.
    encoder_resolution: int = 0
    gyro_noise: float = 0.0  # Standard deviation of a sample [rad/s].
    gyro_bias: float = 0.0  # [rad/s].
    # Of `base_measured`, of a tracker outside: standard deviation of a sample.
    measured_noise: float = 0.0  # Of v and v_y [m/s].
    measured_yaw_noise: float = 0.0  # Of omega [rad/s].
    measured_latency: float = 0.0  # Whole control periods [s].
    seed: int = 0  # Of all noise.

    def check(self) -> None:
        """Raises `ParameterError` unless all are in range."""
        within(self, Range(0, 10_000_000), "encoder_resolution")
        within(self, Range(0.0, 10.0, "rad/s"), "gyro_noise", "measured_yaw_noise")
        within(self, Range(-10.0, 10.0, "rad/s"), "gyro_bias")
        within(self, Range(0.0, 10.0, "m/s"), "measured_noise")
        within(self, Range(0.0, 2.0, "s"), "measured_latency")
        within(self, Range(0, 1e8), "seed")

    def check_period(self, period: float) -> None:
        """Raises `ParameterError` unless the latency is whole periods [s]."""
        check_whole(self, "measured_latency", period, "control periods")

    @property
    def deviations(self) -> list[float]:
        """Returns the noise's standard deviations (4,): gyroscope, v, v_y, omega."""
        v = self.measured_noise
        return [self.gyro_noise, v, v, self.measured_yaw_noise]


class Noise(LeafSystem):
    """White noise: normal numbers, new at each tick, the same in each run.

    .. pydrake_system::

        name: Noise
        output_ports:
        - noise

    The state is the noise. That of tick k is drawn by a generator that is keyed by the
    seed and k: nothing else is kept.

    Args:
        means: of the numbers (m,).
        deviations: their standard deviations (m,).
        seed: of the generator.
        period: between two ticks [s].
    """

    def __init__(
        self, means: list[float], deviations: list[float], seed: int, period: float
    ) -> None:
        super().__init__()
        self.means, self.deviations = np.array(means), np.array(deviations)
        self.seed, self.period = seed, period
        noise = self.DeclareDiscreteState(self.drawn(0))
        self.DeclareStateOutputPort("noise", noise)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._renew)

    def drawn(self, tick: int) -> np.ndarray:
        """Returns the noise (m,) at a tick."""
        numbers = np.random.Generator(np.random.Philox(key=self.seed, counter=tick))
        return self.means + self.deviations * numbers.standard_normal(len(self.means))

    def _renew(self, context: Any, state: Any) -> None:
        tick = round(context.get_time() / self.period) + 1
        state.get_mutable_vector().SetFromVector(self.drawn(tick))


def encoder_rates(
    builder: DiagramBuilder, angles: OutputPort, resolution: int, period: float
) -> OutputPort:
    """Returns wheels' rates (m,) [rad/s] by encoders: counts since the last tick.

    Args:
        builder: to add to.
        angles: of the wheels (m,) [rad], zero in the beginning.
        resolution: of the encoders [counts a turn].
        period: control period [s].
    """
    size = angles.size()
    encoders = builder.AddNamedSystem("encoders", RotaryEncoders([resolution] * size))
    eye: Any = np.eye(size)
    # The state is the last angle: y = (u - x) / period.
    rates = builder.AddSystem(
        LinearSystem(0 * eye, eye, -eye / period, eye / period, period)
    )
    builder.Connect(angles, encoders.get_input_port())
    builder.Connect(encoders.get_output_port(), rates.get_input_port())
    return rates.get_output_port()


def measured_motion(
    builder: DiagramBuilder, velocity: OutputPort, sensors: Sensors, period: float
) -> tuple[OutputPort, OutputPort]:
    """Returns the yaw rate of a gyroscope (1), and v, v_y, omega by a tracker (3).

    Args:
        builder: to add to.
        velocity: the true `base_velocity` (3).
        sensors: their faults.
        period: control period [s].
    """
    late = delayed(builder, velocity, sensors.measured_latency, period)
    yaw = builder.AddSystem(Demultiplexer([2, 1]))
    builder.Connect(velocity, yaw.get_input_port())
    gyro = yaw.get_output_port(1)
    if sensors.gyro_bias or any(sensors.deviations):
        means = [sensors.gyro_bias, 0.0, 0.0, 0.0]
        noise = Noise(means, sensors.deviations, sensors.seed, period)
        parts = builder.AddSystem(Demultiplexer([1, 3]))
        builder.Connect(
            builder.AddNamedSystem("noise", noise).get_output_port(),
            parts.get_input_port(),
        )
        gyro = _sum(builder, gyro, parts.get_output_port(0))
        late = _sum(builder, late, parts.get_output_port(1))
    return gyro, late


def _sum(builder: DiagramBuilder, a: OutputPort, b: OutputPort) -> OutputPort:
    adder = builder.AddSystem(Adder(2, a.size()))
    builder.Connect(a, adder.get_input_port(0))
    builder.Connect(b, adder.get_input_port(1))
    return adder.get_output_port()
