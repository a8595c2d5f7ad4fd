"""Linear algebra, rotations, screws and graphs, independent of robots."""
