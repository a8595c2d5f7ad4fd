"""Dynamics of a robot: small vibrations about a pose (natural frequencies, modes, harmonic response), and trajectories."""
