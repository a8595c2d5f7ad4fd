"""Statics of single limbs: the wrenches that they transmit, their compliance, and their sag under their own weight."""
