"""Sub-problem 2 of the paper: paths and moving costs in wind between every ordered pair of nodes.

`costing.instance_of(scenario, method)` turns a Scenario into an Instance and the Paths behind its costs; the methods
(`registry.METHODS`) share the search field (`field`: gauge and vorticity), the free space and the graph.
"""
