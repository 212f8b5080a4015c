"""A guiding hand that nobody leads."""

import dataclasses as dc
from typing import ClassVar


@dc.dataclass
class Planned:
    """The hand that pulls goes along its own path."""

    fed: ClassVar[bool] = False
    finite: ClassVar[bool] = True

    def build(self, _period: float) -> None:
        """Returns no source."""
