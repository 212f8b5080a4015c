"""Who moves, base or arm: one file a decomposer, and the laws they share.

A dataclass imported here is in scenarios, on the command line and in the console.
"""

from typing import TYPE_CHECKING

from drake_mobman.base import BaseController
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.decomposer import DecomposerParams
from drake_mobman.decomposers.diff_ik import DiffIk
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.qp import Qp
from drake_mobman.decomposers.switching import Switching
from drake_mobman.kinds import unions_of

if TYPE_CHECKING:
    Decomposer = DecomposerParams
else:
    (Decomposer,) = unions_of(globals(), DecomposerParams)
    # With one of them, the arm does the rest.
    Decomposer |= BaseController
