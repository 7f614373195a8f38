"""The linear relaxation of the paper's MILP, solved once."""
