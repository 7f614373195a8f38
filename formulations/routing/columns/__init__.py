"""Columns: the MMMDMTSP as a choice of one tour per UAV. The parts of `branch-and-price`, in the order they run.

legs → completion → labelling → pricing → master → generation → fixing → pool → cuts → branching, all in tightening,
the work on a node, and tree over the nodes; destructive where a gap stays wide.
"""
