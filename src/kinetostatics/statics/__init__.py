"""Statics of the robot: equilibrium of the platform, Eqs. (11) and (12), and displacements of all parts."""
