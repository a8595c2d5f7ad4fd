"""Structure of a robot: joints, rigid bodies, beams, and the limbs that connect base and platform."""
