"""A guiding hand that no operator steers."""

import dataclasses as dc
from typing import ClassVar


@dc.dataclass
class Planned:
    """The guiding hand moves along its own path."""

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = True

    def build(self, _period: float) -> None:
        """Returns no source."""
