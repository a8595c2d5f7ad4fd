"""Robot files (URDF, xacro) read and written; every error names file and line."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
