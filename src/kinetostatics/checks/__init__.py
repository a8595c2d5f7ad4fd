"""Properties of a robot before any load: limbs, mobility, redundancy, warnings; the data of ``kinetostatics check``."""
