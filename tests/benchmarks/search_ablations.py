"""What `search.py ablation` leaves out of `memetic`, one ingredient at a time."""

from __future__ import annotations

from dataclasses import replace

from formulations.routing.search.leg_potentials import PotentialParameters
from formulations.routing.search.parameters import SearchParameters
from formulations.routing.search.strategy import Reheating

FULL = SearchParameters()
SHORT = FULL.several_depots.short
PACKING = FULL.one_site.packing
assert SHORT is not None
assert PACKING is not None
NO_TRIMMING = PACKING.trimming._replace(share=0.0)
ONE_ERA = PACKING.eras._replace(stale=float("inf"))
NO_CAP, NO_REHEATING = replace(FULL.schedule.final, below=0.0), Reheating(share=0.0)
PARAMETERS: dict[str, SearchParameters] = {  # ingredients that are parameters of memetic
    "no cap in the end (p-norm throughout)": replace(
        FULL,
        schedule=replace(FULL.schedule, final=NO_CAP),
        several_depots=replace(FULL.several_depots, fine=replace(FULL.several_depots.fine, below=0.0)),
        one_site=replace(FULL.one_site, fine=replace(FULL.one_site.fine, below=0.0)),
    ),
    "no fine annealings": replace(
        FULL,
        several_depots=replace(FULL.several_depots, fine_share=0.0),
        one_site=replace(FULL.one_site, fine_share=0.0, reheating=NO_REHEATING, packing=replace(PACKING, reheated=0.0)),
    ),
    "no reheating": replace(
        FULL,
        one_site=replace(FULL.one_site, reheating=NO_REHEATING, packing=replace(PACKING, reheated=0.0)),
    ),
    "reheatings of many UAVs at one site as of few": replace(
        FULL, one_site=replace(FULL.one_site, packing=replace(PACKING, reheated=0.0))
    ),
    "no quenches": replace(FULL, one_site=replace(FULL.one_site, quench=None)),
    "no pull of the mean over plateaus": replace(FULL, schedule=replace(FULL.schedule, most_weight=0.0)),
    "no compact annealings": replace(FULL, one_site=replace(FULL.one_site, compact=0.0)),
    "many UAVs at one site as few": replace(FULL, one_site=replace(FULL.one_site, packing=None)),
    "no capped annealings": replace(
        FULL, one_site=replace(FULL.one_site, packing=replace(PACKING, founders=0.0, others=0.0))
    ),
    "as many capped founders whether or not they succeed": replace(
        FULL, one_site=replace(FULL.one_site, packing=replace(PACKING, recent=0.0))
    ),
    "one era": replace(FULL, one_site=replace(FULL.one_site, packing=replace(PACKING, eras=ONE_ERA))),
    "no trimmed tours": replace(FULL, one_site=replace(FULL.one_site, packing=replace(PACKING, trimming=NO_TRIMMING))),
    "no parted tasks": replace(
        FULL,
        several_depots=replace(FULL.several_depots, parting=None),
        one_site=replace(FULL.one_site, parting=None),
    ),
    "members as near as they come": replace(
        FULL, several_depots=replace(FULL.several_depots, apart=0.0), one_site=replace(FULL.one_site, apart=0.0)
    ),
    "members nearer each other, with several depots": replace(
        FULL, several_depots=replace(FULL.several_depots, apart=0.1)
    ),
    "as many perturbations whether or not they succeed": replace(FULL, population=replace(FULL.population, recent=0.0)),
    "eight members, with several depots": replace(FULL, several_depots=replace(FULL.several_depots, size=8)),
    "searches of some tours alone, with several depots": replace(
        FULL, several_depots=replace(FULL.several_depots, focused=True)
    ),
    "no long founders": replace(FULL, several_depots=replace(FULL.several_depots, long=None)),
    "short tours perturbed as longer ones": replace(
        FULL,
        several_depots=replace(FULL.several_depots, short=replace(SHORT, perturbed=1.0, bounded=True)),
    ),
    "short tours as longer ones": replace(FULL, several_depots=replace(FULL.several_depots, short=None)),
    "children inherit tours from anywhere": replace(FULL, several_depots=replace(FULL.several_depots, regions=0.0)),
    "no chained search across long tours": replace(FULL, handover=replace(FULL.handover, uavs=0, many=10**9)),
    "no chained search that begins hot": replace(FULL, handover=replace(FULL.handover, each=10**9)),
    "no growth from the farthest tasks on": replace(FULL, handover=replace(FULL.handover, grown=0.0)),
    "no edge assembly: chained search alone": replace(FULL, assembly=FULL.assembly._replace(size=1)),
    "rings without kicks": replace(FULL, assembly=FULL.assembly._replace(kicks=0.0)),
    "kicks of short segments": replace(FULL, assembly=FULL.assembly._replace(walk=0)),
    "no bridges": replace(FULL, assembly=FULL.assembly._replace(bridged=0)),
    "no searches of parts": replace(FULL, parts=FULL.parts._replace(tasks=0)),
    "no chained search in the end": replace(FULL, handover=replace(FULL.handover, many=10**9)),
    "no potentials: near is what costs least": replace(
        FULL, neighbourhood=FULL.neighbourhood._replace(potentials=PotentialParameters(most=0))
    ),
    "tasks numbered as the instance numbers them": replace(FULL, renumbered=10**9),
    "ends of many tours": replace(FULL, one_site=replace(FULL.one_site, depots=FULL.several_depots.depots)),
    "no wide recreation": replace(FULL, one_site=replace(FULL.one_site, width=FULL.several_depots.width)),
}
OPTIONS: dict[str, dict[str, float]] = {  # ingredients that are options of memetic
    "all": {},
    "no moves of long segments": {"cuts": 0.0},
    "no string removal": {"strings": 0.0},
    "no adjacent removal": {"strings": 1.0},
    "insertion by total cost only (p = 1)": {"powers": 1},
    "p of 1 and 2 only": {"powers": 2},
    "no guide by the longest tour left (p = ∞)": {"powers": 5},
    "no decomposition": {"focuses": 0.0},
    "no perturbation of the whole": {"reliefs": 0.0},
    "no crossover": {"reliefs": 1.0},
    "no search of single tours' orders": {"kicks": 0.0},
    "one long annealing, no population": {"depth": 1e9},
    "removals of at most 6": {"removals": 6},
}
