"""Compiled code of a robot's kinematics and statics: the scalar operations of the NumPy functions are recorded and compiled."""
