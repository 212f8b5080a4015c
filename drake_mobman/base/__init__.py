"""The base: what drives it, and how its commands are smoothed and limited.

A dataclass imported here is available in scenarios, command line and console.
"""

from typing import TYPE_CHECKING

from drake_mobman.base.controller import BaseControllerParams
from drake_mobman.base.jerk_limited import JerkLimited
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.smoothing import SmoothingParams
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.kinds import unions_of

if TYPE_CHECKING:
    BaseController = BaseControllerParams
    Smoothing = SmoothingParams
else:
    BaseController, Smoothing = unions_of(
        globals(), BaseControllerParams, SmoothingParams
    )
