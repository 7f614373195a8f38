"""Columns: the MMMDMTSP as a choice of one tour per UAV. The parts of `branch-and-price`, in the order they run.

legs → completion → label_search, of labels of one kind (labelling; state_labelling where nodes have several states) →
pricing → master → generation → fixing → pool → cuts → branching, all in tightening, the work on a node, and tree over
the nodes; destructive where a gap stays wide.
"""
