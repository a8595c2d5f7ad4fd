"""Compiled functions of a robot: chosen quantities of a pose, and their derivatives, from coordinates, load and gravity."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
