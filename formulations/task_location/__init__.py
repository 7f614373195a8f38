"""Task locations that maximise mutual information (the paper's sub-problem 1)."""
