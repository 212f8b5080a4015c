"""Engines: what steps a robot's plant.

A dataclass imported here is available in scenarios and on the command line.
"""

from typing import TYPE_CHECKING

from drake_mobman.engines.drake import Drake
from drake_mobman.engines.engine import EngineParams
from drake_mobman.engines.mujoco.params import Mujoco
from drake_mobman.kinds import unions_of

if TYPE_CHECKING:
    Engine = EngineParams
else:
    (Engine,) = unions_of(globals(), EngineParams)
