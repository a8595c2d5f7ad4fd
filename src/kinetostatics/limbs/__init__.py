"""Limbs, each by itself: constraint and attached wrenches, compliance, sag under its own weight."""
