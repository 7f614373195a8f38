"""Routing: the min-max multi-depot multiple TSP (the paper's sub-problem 3)."""
