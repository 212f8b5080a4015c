"""A scenario simulated: its log, and the folder it goes to."""
