"""Loops as other tools write them: closing frames of onshape-to-robot, Gepetto's ``robot.yaml``, Isaac Sim's ``<loop_joint>``."""
