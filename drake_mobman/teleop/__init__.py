"""Where commands come from, and the guard that lets them in.

A dataclass imported here is in scenarios and on the command line.
"""

from typing import TYPE_CHECKING

from drake_mobman.kinds import unions_of
from drake_mobman.teleop.external import External
from drake_mobman.teleop.live import Operator
from drake_mobman.teleop.random_held import RandomHeld
from drake_mobman.teleop.recorded import Recording
from drake_mobman.teleop.scripted import Script
from drake_mobman.teleop.source import SourceParams

if TYPE_CHECKING:
    Source = SourceParams
else:
    (Source,) = unions_of(globals(), SourceParams)
