"""The hand that pulls: a person who guides the robot by its tool."""
