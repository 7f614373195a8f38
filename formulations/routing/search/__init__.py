"""Min-max route search: ruin-and-recreate and the memetic search, as small numba kernels on flat arrays.

Words of our own, and options whose names differ from the field's:

* leg: one arc of a tour; temperatures are in mean legs. Site: a place where one or more UAVs start.
* measure: how tours count together, by a p-norm or by what exceeds a cap; guide: the measure a recreation goes by.
* incumbent: the longest tour of the best tours known; crowding: n² / m, what the length of an annealing goes by.
* packing: what is done where the farthest task leaves many UAVs of one site little time; trimming: a tour gives tasks
  away until it is shorter than any known (packing.py, trimming.py).
* era: what a family that packs found since it last began from scratch; champions are the best of eras (eras.py).
* parting: two tasks of the longest tour must be flown by different UAVs while an annealing lasts (parting.py).
* stage: one annealing of a newcomer of the population; a fine annealing ends colder, with a cap nearer the incumbent.
* options of `memetic`: cuts, share of steps that are moves of long segments (moves.py); powers, number of guides;
  focuses, share of stages that are decompositions; reliefs, share of perturbations; kicks, number of double bridges.

From the bottom up: costs, numbering, leg_potentials, problem_data and tours hold the data, and endurance scales costs
to what can be flown; energy measures tours; ruin, recreate, moves (by concatenation) and local_search change them;
annealing under a schedule is `ruin_recreate`; decomposition, perturbation, crossover, parting and, with trimming,
packing make a population of a strategy, whose stages and eras are `memetic`; parameters has all that was tuned. Where
tours from one site are long, handover says when edge_assembly (of rings from nearest_in_turn, each a giant_tour, by
ab_cycles and ring_children) or chained_search (by chain_moves of candidate_legs on tour_blocks, judged by ring_energy,
and by bridges) takes over; growth may come before it, part_search may follow.
"""
