"""Buckling: stiffness and geometric stiffness of the whole robot, its critical load factors, and the members that buckle."""
