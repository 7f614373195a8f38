"""workbench bound: lower bounds on the longest tour."""
