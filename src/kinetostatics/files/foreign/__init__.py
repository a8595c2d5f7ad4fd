"""Loops in formats of other tools: closing frames of onshape-to-robot, Gepetto's ``robot.yaml``, Isaac Sim's ``<loop_joint>``."""
