"""Figures: draw frames. Each returns a matplotlib figure with its caption in words."""
