"""Lower bounds on the longest tour, each valid in floating point."""
