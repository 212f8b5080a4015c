"""The base: its unicycle, and the smoothing and rate limit of its commands."""
