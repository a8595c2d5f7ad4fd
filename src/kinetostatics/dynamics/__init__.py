"""Small vibrations of a robot about a pose: natural frequencies, modes and harmonic response."""
