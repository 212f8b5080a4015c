"""The controller of a scenario as C99: header, source, test vectors, test program."""

import dataclasses as dc
import re
from typing import Any

import numpy as np

from drake_mobman import __version__, signals
from drake_mobman.diagrams.controller import make_controller_diagram
from drake_mobman.export.law.c_code import function, number
from drake_mobman.export.law.templates import HEADER, MAKEFILE, SOURCE, TEST, VECTORS
from drake_mobman.operations import programs
from drake_mobman.scenario import AnyScenario, ScenarioError, Teleop
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.simulate import simulate
from drake_mobman.step_law import StepLaw, StepLawError, Vector, step_law
from drake_mobman.teleop.scripted import Held, Script, Smooth

_TICKS = 500
"""In the test vectors."""

_UNITS = {
    signals.EE_COMMAND: "v_c [m/s] along the reach, omega_c [rad/s], v_z [m/s] up",
    signals.ARM_POSITION: "joint positions [rad], of a sliding joint [m]",
    signals.BASE_POSE: "x, y [m], theta [rad] of the base in the world",
    signals.BASE_ODOMETRY: "v [m/s], omega [rad/s] of the base by its encoders",
    signals.BASE_GYRO: "omega [rad/s] of the base by a gyroscope",
    signals.BASE_MEASURED: "v, v_y [m/s], omega [rad/s] of the base, measured",
    signals.BASE_COMMAND_SMOOTHED: "v_b [m/s] forward, omega_b [rad/s] to the left",
    signals.ARM_VELOCITY_COMMAND: "joint rates [rad/s], of a sliding joint [m/s]",
    signals.GUARD_STATUS: "why the guard stops the command; 0: it does not",
    signals.DECOMPOSER_STATUS: "sum of flags: what slows the end effector down",
    signals.ARM_STATUS: "sum of flags: what bounds the joint rates",
}


@dc.dataclass(frozen=True)
class Controller:
    """A scenario's controller as a law, and its name in C."""

    name: str
    scenario: Teleop
    law: StepLaw

    @classmethod
    def of(cls, scenario: AnyScenario) -> "Controller":
        """Returns the controller of a scenario.

        Raises:
            ScenarioError: where it has none that can be written as C.
        """
        if not isinstance(scenario, Teleop):
            tag = type(scenario).__name__
            raise ScenarioError(f"!{tag} has no controller as C; must be !Teleop")
        try:
            law = step_law(make_controller_diagram(scenario))
        except StepLawError as error:
            raise ScenarioError(f"has no controller as C: {error}") from None
        return cls(_identifier(scenario.name), scenario, law)

    def files(self) -> dict[str, bytes]:
        """Returns the contents of all files, by name; the same at each call."""
        name, fields = self.name, self._fields()
        templates = {
            f"{name}.h": HEADER,
            f"{name}.c": SOURCE,
            f"{name}_vectors.h": VECTORS,
            f"test_{name}.c": TEST,
            "Makefile": MAKEFILE,
        }
        return {
            file: re.sub(r"@(\w+)@", lambda found: fields[found[1]], template).encode()
            for file, template in templates.items()
        }

    def _fields(self) -> dict[str, str]:
        """Returns what is filled into the templates, by name."""
        law = self.law
        step, begin = programs(law.trace, [law.step, law.begin])
        inputs = [x for x in law.inputs if x.name != signals.EE_COMMAND]
        expected = _recorded(self.scenario, law)
        return {
            "name": self.name,
            "NAME": self.name.upper(),
            "version": __version__,
            "about": _comment(self.scenario.description or self.scenario.name),
            "period": number(law.period),
            "num_state": str(_size(law.state)),
            "num_inputs": str(_size(law.inputs)),
            "num_measured": str(_size(inputs)),
            "num_outputs": str(_size(law.outputs)),
            "inputs": _members(law.inputs),
            "outputs": _members(law.outputs),
            "start": ", ".join(map(number, law.start)) or "0",
            "step": function("law", step),
            "begin": function("initialization", begin),
            "flat_inputs": _copied(law.inputs, "in", "input", to="in"),
            "flat_outputs": _copied(law.outputs, "out", "output", to="struct"),
            "count": str(len(expected)),
            "vectors": ",\n".join(
                "  {" + ", ".join(map(number, row)) + "}" for row in expected.tolist()
            ),
        }


def _size(vectors: Any) -> int:
    return sum(x.size for x in vectors)


def _identifier(name: str) -> str:
    """Returns a name as C can have it."""
    name = re.sub(r"\W", "_", name, flags=re.ASCII) or "controller"
    return f"c_{name}" if name[0].isdigit() else name


def _comment(text: str) -> str:
    """Returns a text that may stand in a comment in C."""
    return text.replace("*/", "* /").encode("ascii", "replace").decode()


def _members(vectors: tuple[Vector, ...]) -> str:
    return "\n".join(
        f"  double {x.name}[{x.size}]; /* {_UNITS[x.name]} */" for x in vectors
    )


def _copied(vectors: tuple[Vector, ...], flat: str, struct: str, to: str) -> str:
    """Returns lines that copy between a struct and an array."""
    lines, place = [], 0
    for x in vectors:
        a, b = f"{flat} + {place}", f"{struct}->{x.name}"
        a, b = (a, b) if to == flat else (b, a)
        lines.append(f"  memcpy({a}, {b}, {x.size} * sizeof(double));")
        place += x.size
    return "\n".join(lines)


def _recorded(scenario: Teleop, law: StepLaw) -> np.ndarray:
    """Returns inputs and outputs at each tick, as the blocks had them in a run."""
    run = _run(scenario)
    inputs = [_logged(run, x.name, given=True) for x in law.inputs]
    outputs = [_logged(run, x.name, given=False) for x in law.outputs]
    return np.hstack([*inputs, *outputs])


def _logged(run: Run, name: str, *, given: bool) -> np.ndarray:
    """Returns a signal of a run; the command is what came before the guard."""
    own = f"source.{name}"
    return run[own if given and own in run.log else name]


def _run(scenario: Teleop) -> Run:
    """Returns a short run, with commands of a script."""
    source = scenario.source if isinstance(scenario.source, Script) else _SCRIPT
    duration = min(scenario.duration, (_TICKS - 1) * scenario.period)
    run = simulate(
        dc.replace(
            scenario,
            source=source,
            duration=duration,
            alternatives=[],
            compiled=False,
        )
    )
    if run.died:
        raise ScenarioError(f"has no test vectors: {run.died}")
    return run


_SCRIPT = Script(
    [
        Held(0.5, v_c=0.1),
        Smooth(0.5, v_c=0.2, omega_c=0.2),
        Held(1.0, v_c=0.2, omega_c=0.2),
        Smooth(1.0, v_c=-0.2, omega_c=-0.2),
        Held(1.0, v_c=-0.2, omega_c=-0.2),
        Held(0.5),
    ]
)
"""Commands for a scenario that has none of its own."""
