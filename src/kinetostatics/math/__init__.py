"""Mathematics that knows nothing of robots: linear algebra, rotations, screws, arrays."""
