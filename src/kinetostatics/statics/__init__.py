"""All limbs together: equilibrium of the platform, and what deforms."""
