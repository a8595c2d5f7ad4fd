"""Functions that make the reports of robots, poses and results."""
