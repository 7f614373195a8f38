"""Flight and Gaussian-process mapping (the paper's sub-problem 4)."""
