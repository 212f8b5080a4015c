"""Who moves, base or arm: one file a decomposer, and the law they share."""
