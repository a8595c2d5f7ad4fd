"""Statics of single limbs: constraint and attached wrenches, compliance, sag under their own weight."""
