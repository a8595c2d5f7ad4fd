"""Loops in the formats of other tools: frames of onshape-to-robot, Gepetto's ``robot.yaml``, Isaac Sim's ``<loop_joint>``."""
