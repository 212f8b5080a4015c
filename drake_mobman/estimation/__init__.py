"""How the base is about to move, by what is sent and what is measured.

A dataclass imported here is available in scenarios, on the command line and in the
console.
"""

from typing import TYPE_CHECKING

from drake_mobman.estimation.estimate import EstimateParams
from drake_mobman.estimation.gyro import Gyro
from drake_mobman.estimation.measured import Measured
from drake_mobman.estimation.odometry import Odometry
from drake_mobman.estimation.sent import Sent
from drake_mobman.kinds import unions_of

if TYPE_CHECKING:
    Estimate = EstimateParams
else:
    (Estimate,) = unions_of(globals(), EstimateParams)
