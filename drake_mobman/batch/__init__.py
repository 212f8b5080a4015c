"""Many runs of one law at once, without Drake's simulator."""
