"""Studies, for `mobman compare --over NAME`: a study imported here can be chosen."""

from drake_mobman.analysis.studies.faults import Faults
from drake_mobman.analysis.studies.in_engines import InEngines
from drake_mobman.analysis.studies.robots import Robots
from drake_mobman.analysis.studies.study import Column, Studied, Study, studied

STUDIES: dict[str, Study] = {study.name: study for study in (Faults(), Robots())}
"""All studies by name."""

__all__ = ["STUDIES", "Column", "InEngines", "Studied", "Study", "studied"]
