"""A controller as C: the same operations as its blocks', in the same order."""
