"""branch-and-cut: the paper's MILP in SCIP, subtour cuts added inside the tree."""
