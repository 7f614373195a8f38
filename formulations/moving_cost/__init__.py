"""Sub-problem 2 of the paper: paths and moving costs in wind between every ordered pair of nodes.

`costing.instance_of(scenario, method)` turns a Scenario into an Instance and the Paths behind its costs, and
`families.generate(name, n_tasks, n_depots, seed)` makes the Instance of a generator family. C(σ) is `moving_cost` in
`instances.moving_cost`, FMT* is `fmt_star`; the methods (`registry.METHODS`) that search share the search field
(`field`: gauge and vorticity), the free space and the graph.
"""
