"""How each sub-problem of the paper is posed and solved, one folder each, in the paper's order."""
