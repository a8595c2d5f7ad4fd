"""Compiled code of kinematics and statics, recorded once per structure of a robot from the NumPy functions."""
