"""What a scenario says, and where it is read from."""
