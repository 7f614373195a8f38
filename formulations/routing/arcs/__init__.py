"""Branch and cut over the arcs of the paper's MILP, with a tree whose every bound can be computed again."""
