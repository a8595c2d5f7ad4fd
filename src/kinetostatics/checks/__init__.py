"""Properties of a robot without loads: limbs, mobility, redundancy, warnings; the data of ``kinetostatics check``."""
