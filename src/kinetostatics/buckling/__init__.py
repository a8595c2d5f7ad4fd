"""Buckling: stiffness and geometric stiffness of the robot, critical load factors, and the members that buckle."""
