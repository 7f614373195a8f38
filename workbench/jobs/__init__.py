"""The machinery of comparisons: processes and files, and no problem.

study → jobs → a fresh process each (child, worker) → what is verified (runner) → one file a run (store).
What a problem adds, `jobs.problem.Problem` says; the problems are in `workbench.problems`.
"""
