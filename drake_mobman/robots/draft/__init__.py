"""Drafts of robot files: what a model's joints are for, told from their geometry."""

from drake_mobman.robots.draft.guess import Guess, guessed
from drake_mobman.robots.draft.write import written

__all__ = ["Guess", "guessed", "written"]
