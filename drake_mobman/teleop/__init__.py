"""Where commands come from, and the guard that lets them in."""

from drake_mobman.teleop.external import External
from drake_mobman.teleop.live import Operator
from drake_mobman.teleop.recorded import Recording
from drake_mobman.teleop.scripted import Script

Source = Script | External | Operator | Recording
"""Who commands the end effector. Each is a dataclass as `SourceParams` has it."""

__all__ = ["External", "Operator", "Recording", "Script", "Source"]
