"""Compiled functions of a robot: from coordinates, load and gravity to chosen quantities of the pose and their derivatives."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
