"""Decomposers split a command between base and arm: one file each, and shared laws.

A dataclass imported here is available in scenarios, command line and console.
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
    # A base controller can decompose too: the arm then compensates for the base.
    Decomposer |= BaseController
