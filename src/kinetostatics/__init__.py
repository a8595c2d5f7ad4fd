"""Sag, stiffness and actuator forces of parallel manipulators, straight from a URDF."""
