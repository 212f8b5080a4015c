"""Drafts of robot files: what a model's joints are for, told from their geometry."""

from drake_mobman.robots.draft.draft import BASES, Mount, drafted

__all__ = ["BASES", "Mount", "drafted"]
