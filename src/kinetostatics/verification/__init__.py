"""Independent verification by finite elements: the robot at a pose as a frame of beams and joints in OpenSeesPy.

The frame is built from the robot's file and the frames of its links alone. Limbs, wrenches and compliances are not used, and are
therefore verified independently. The page on verification lists the parts common to both computations.
"""

from kinetostatics.verification.compare import Verification, verify
from kinetostatics.verification.opensees import FrameSolution, OpenSeesError

__all__ = ["FrameSolution", "OpenSeesError", "Verification", "verify"]
