"""Violated cuts of the paper's MILP at an integer or fractional point."""
