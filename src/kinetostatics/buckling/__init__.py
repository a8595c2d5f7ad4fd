"""Members under compression: runs of beams in one line, how their ends are held, and when they buckle."""
