"""Exact dynamic stiffness of beams and robots, eigenvalues and modes."""
