"""Moving costs between tasks in a wind field (the paper's sub-problem 2)."""
