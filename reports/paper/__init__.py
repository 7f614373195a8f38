"""Paper: what a study found, for LaTeX: tables of method by size, figures, references."""
