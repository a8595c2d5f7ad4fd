"""Workspace maps: results of a robot and its variants on a grid of poses, as one labelled Dataset."""

from kinetostatics.workspace.run import sweep

__all__ = ["sweep"]
