"""An independent check by finite elements: the same robot at the same pose as a frame of beams and joints in OpenSeesPy.

The frame is built from the robot's file and the frames of its links, not from limbs, wrenches or compliances: a mistake in those
cannot hide. What both share, and what therefore is not checked, is said in the page on how we know it is right.
"""

from kinetostatics.verification.compare import Verification, verify
from kinetostatics.verification.opensees import FrameSolution, OpenSeesError

__all__ = ["FrameSolution", "OpenSeesError", "Verification", "verify"]
