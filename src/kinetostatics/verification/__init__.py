"""Independent verification by finite elements: the robot at a pose as a frame of beams and joints in OpenSeesPy.

The frame is built only from the robot's file and the poses of its links, not from the limbs, wrenches and compliances that it
verifies. The page on verification lists the code that both computations share.
"""

from kinetostatics.verification.compare import Verification, verify
from kinetostatics.verification.opensees import FrameSolution, OpenSeesError

__all__ = ["FrameSolution", "OpenSeesError", "Verification", "verify"]
