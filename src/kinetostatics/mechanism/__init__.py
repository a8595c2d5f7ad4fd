"""What a robot consists of: joints, rigid bodies, beams, and the limbs that connect base and platform."""
