"""How blocks are wired: a module a diagram."""
