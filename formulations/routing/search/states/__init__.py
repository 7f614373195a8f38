"""Search over instances with several states at a node, such as headings: kernels of their own.

A tour costs the cheapest chain of states through its nodes. With

    F_p(a)   the least cost from the depot to state a of the node at position p (a prefix)
    G_p(b)   the least cost from state b of that node home (a suffix)

kept for every tour, task v between the nodes at p and q = p + 1 makes the tour cost

    min_c [min_a F_p(a) + c(a, c)] + [min_b c(c, b) + G_q(b)]

in 2H² additions, whatever the length of the tour (Babel, J. Heuristics 26 (2020), for headings). `costs` holds the
legs, `tours` the tours with F and G, `annealing` ruins and recreates them, `searching` is what `memetic` runs.
"""
