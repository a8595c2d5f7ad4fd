"""Limbs, each by itself: the wrenches it carries, its compliance, how its own weight deforms it."""
