"""Drafts of robot files: what a model's joints are for, told from their geometry."""

from drake_mobman.robots.draft.guess import Guess, guessed

__all__ = ["Guess", "guessed"]
