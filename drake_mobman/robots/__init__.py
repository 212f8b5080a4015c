"""Robots: a URDF each, and the robot as a diagram at each fidelity."""
