"""Columns: the MMMDMTSP as a choice of one tour per UAV. The parts of `branch-and-price`, in the order they run.

legs → completion → labelling → pricing → master → generation → enumeration → pool, and tree over them.
"""
