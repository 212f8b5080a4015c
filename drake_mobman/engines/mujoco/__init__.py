"""A robot's plant in MuJoCo, made from the finished `MultibodyPlant`."""
