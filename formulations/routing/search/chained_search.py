"""Chained local search for few UAVs and long tours: kicks and Lin-Kernighan repairs across tours, annealed.

Ruin and recreate and searches of single tours leave long tours 0.5 to 1 % above the best known, nearly all of it in
which task is on which tour. Here one search sees both. A kick is a double bridge of four legs of the giant tour, near
each other along it or along candidate legs; a descent repairs it around the nodes it touched, each node taking the best
of its own moves (chain_moves.py, bridges.py). What a kick and its repair come to is accepted by annealing, or undone
(large-step Markov chain, Martin, Otto & Felten 1991; chained Lin-Kernighan and its walks, Applegate, Cook & Rohe 2003).

Of kicks along the tour 97 in 100 are undone by their own repair: they are for annealings from high temperatures. Cold,
a kick at the ends of walks is worth far more, though it takes two to five times as long: rl5915_3 from the nearest
tasks in turn, 12 to 15 s at 0.05 to 0.8 mean legs, by script, total 2.3 to 3.2 % above that of the best routes known
with the ones, 0.8 to 1.9 % with the others.
For UAVs that are alike and fly from one site, at costs that are symmetric.
"""

from __future__ import annotations

import math

import numpy as np

from formulations.routing.search.bridges import best_bridge
from formulations.routing.search.candidate_legs import CandidateLegs, candidate_legs
from formulations.routing.search.chain_moves import Chain, ChainParameters, best_move
from formulations.routing.search.costs import AlikeCosts
from formulations.routing.search.energy import TINY
from formulations.routing.search.giant_tour import tours_of
from formulations.routing.search.problem_data import Nodes, ProblemData
from formulations.routing.search.randomness import Rng, below, uniform
from formulations.routing.search.ring_energy import Pressure, tour_energy
from formulations.routing.search.tour_blocks import (
    SWAPPED,
    TURNED_B,
    TURNED_C,
    add_up,
    keep,
    kept_of,
    longest_of,
    note_change,
    position_of,
    rejoin,
    restore,
    total_of,
    tour_blocks,
    write_ring,
)
from formulations.routing.search.tours import Tours
from instances.arrays import Ints
from instances.kernels import njit


@njit(cache=True, nogil=True)
def _price(chain: Chain, k: int, pressure: Pressure) -> None:
    """Write the energy of tour k."""
    chain.energies[k] = tour_energy(chain.blocks.sums[chain.blocks.ends[k]], pressure)


@njit(cache=True, nogil=True)
def price_all(chain: Chain, pressure: Pressure) -> None:
    """Write the energies of all tours."""
    for k in range(chain.energies.size):
        _price(chain, k, pressure)


@njit(cache=True, nogil=True)
def _make(chain: Chain, pressure: Pressure) -> None:
    """Make the move in `chain.move`, queue the nodes where it cuts and note which tours differ."""
    at, queue, blocks = chain.queue_at, chain.queue, chain.blocks
    p, q, r, kind = chain.move
    for j in range(6):
        v = blocks.order[chain.move[j // 2] + j % 2]
        if not chain.queued[v]:
            chain.queued[v] = True
            queue[(at[0] + at[1]) % queue.size] = v
            at[1] += 1
    rejoin(chain.costs, blocks, p, q, r, kind)
    note_change(blocks, chain.kept, p, q, r)
    _price(chain, p >> blocks.bits, pressure)
    _price(chain, q >> blocks.bits, pressure)
    _price(chain, r >> blocks.bits, pressure)


@njit(cache=True, nogil=True)
def _build(chain: Chain, pressure: Pressure) -> None:
    """Make the bridge in `chain.bridge`: open its ring where it is, then move it."""
    move, (low, within, high, at, turned) = chain.move, chain.bridge
    move[0], move[1], move[2], move[3] = low, within, high, SWAPPED
    _make(chain, pressure)
    if at > high:
        move[0], move[1], move[2], move[3] = low, high, at, SWAPPED + turned * TURNED_B
    else:
        move[0], move[1], move[2], move[3] = at, low, high, SWAPPED + turned * TURNED_C
    _make(chain, pressure)


@njit(cache=True, nogil=True)
def _walked(near: Nodes, v: int, legs: int, rng: Rng) -> int:
    """Return where a walk along so many candidate legs from v ends."""
    for _ in range(legs):
        w = near[v, below(rng, near.shape[1])]
        v = w if w >= 0 else v
    return v


@njit(cache=True, nogil=True)
def _swap(chain: Chain, u: int, v: int, w: int, pressure: Pressure) -> None:
    """Put the two parts between the legs behind three nodes in the other order, neither of them reversed."""
    i, j, k = chain.blocks.position[u], chain.blocks.position[v], chain.blocks.position[w]
    first, last = min(i, j, k), max(i, j, k)
    chain.move[0], chain.move[1], chain.move[2], chain.move[3] = first, i + j + k - first - last, last, SWAPPED
    _make(chain, pressure)


@njit(cache=True, nogil=True)
def _near_along(chain: Chain, span: int, rng: Rng, nodes: Ints) -> bool:
    """Write four nodes near each other along the ring, in its order; say whether they are four."""
    blocks, size = chain.blocks, chain.queue.size
    span = min(span, (size - 1) // 3)
    if span < 1:
        return False
    a, b, c = 1 + below(rng, span), 1 + below(rng, span), 1 + below(rng, span)
    place = below(rng, size - a - b - c)
    for x, further in enumerate((0, a, a + b, a + b + c)):
        nodes[x] = blocks.order[position_of(blocks, place + further)]
    return True


@njit(cache=True, nogil=True)
def _near_around(chain: Chain, walk: int, rng: Rng, nodes: Ints) -> bool:
    """Write four nodes near each other along candidate legs, in the ring's order; say whether they are four."""
    position, begin = chain.blocks.position, below(rng, chain.queue.size)
    for x in range(4):
        v = _walked(chain.near.nodes, begin, walk if x > 0 else 0, rng)
        y = x
        while y > 0 and position[nodes[y - 1]] > position[v]:
            nodes[y] = nodes[y - 1]
            y -= 1
        if y > 0 and nodes[y - 1] == v:
            return False
        nodes[y] = v
    return True


@njit(cache=True, nogil=True)
def _kick(chain: Chain, parameters: ChainParameters, pressure: Pressure, rng: Rng) -> None:
    """Put the three parts between four legs in reverse order, none of them reversed; nothing where walks meet.

    Whole tours between them are the same tours wherever they come, so that two legs more may be exchanged there.
    """
    nodes = np.empty(4, np.int64)
    if parameters.walk > 0:
        found = _near_around(chain, parameters.walk, rng, nodes)
    else:
        found = _near_along(chain, parameters.span, rng, nodes)
    if found:
        _swap(chain, nodes[0], nodes[1], nodes[3], pressure)
        _swap(chain, nodes[0], nodes[2], nodes[3], pressure)


@njit(cache=True, nogil=True)
def _descend(chain: Chain, least: float, parameters: ChainParameters, pressure: Pressure) -> None:
    """Make the best moves of queued nodes, and bridges where there is no other, until there are none."""
    at, queue = chain.queue_at, chain.queue
    while at[1] > 0:
        v = queue[at[0]]
        at[0] = (at[0] + 1) % queue.size
        at[1] -= 1
        chain.queued[v] = False
        while True:
            if best_move(chain, v, least, parameters, pressure) > least:
                _make(chain, pressure)
            elif parameters.bridged > 0 and best_bridge(chain, v, least, parameters, pressure) > least:
                _build(chain, pressure)
            else:
                break


@njit(cache=True, nogil=True)
def chain_kicks(
    chain: Chain, best: Nodes, longest: float, rng: Rng, kicks: int, temperature: float, parameters: ChainParameters
) -> float:
    """Kick and repair `kicks` times at a temperature [s].

    best (N+1,): follows the ring whose longest tour is shortest, at first `longest` [s]; return how long that is then.
    """
    blocks, kept, m = chain.blocks, chain.kept, chain.energies.size
    add_up(chain.costs, blocks)
    pressure = Pressure(total_of(blocks) / m, parameters.scale * temperature)
    price_all(chain, pressure)
    now, least = chain.energies.sum(), parameters.gain * temperature
    for k in range(m):
        kept.since[k] = k << blocks.bits
    keep(blocks, kept)
    for _ in range(kicks):
        for k in range(m):
            kept.since[k] = -1
        _kick(chain, parameters, pressure, rng)
        _descend(chain, least, parameters, pressure)
        then = chain.energies.sum()
        if then > now - temperature * math.log(1.0 - uniform(rng)):
            restore(blocks, kept)
            for k in range(m):
                if kept.since[k] >= 0:
                    _price(chain, k, pressure)
            continue
        keep(blocks, kept)
        now = then
        if longest_of(blocks) < (1.0 - 1e-12) * longest:
            longest = longest_of(blocks)
            write_ring(blocks, best)
    return longest


@njit(cache=True, nogil=True)
def descend_everywhere(chain: Chain, least: float, parameters: ChainParameters, pressure: Pressure) -> None:
    """Make the best moves of all nodes until there is none worth more than `least` [s]."""
    price_all(chain, pressure)
    size = chain.queue.size
    for i in range(size):
        chain.queue[i] = chain.blocks.order[position_of(chain.blocks, i)]
        chain.queued[i] = True
    chain.queue_at[0], chain.queue_at[1] = 0, size
    _descend(chain, least, parameters, pressure)


def chain_legs(costs: AlikeCosts, n_tasks: int, parameters: ChainParameters) -> CandidateLegs:
    """Return the candidate legs of its moves."""
    return candidate_legs(costs.out, n_tasks, parameters.nearest, parameters.layers, parameters.most)


class ChainedSearch:
    """A chained local search under way, from tours of its own."""

    def __init__(
        self, data: ProblemData, tours: Tours, parameters: ChainParameters, rng: Rng, near: CandidateLegs | None = None
    ) -> None:
        costs = data.costs
        assert isinstance(costs, AlikeCosts)
        nodes, m = tours.after.size, tours.cost.size
        room = np.zeros(nodes, np.int32), np.zeros(nodes, np.bool_), np.zeros(2, np.int64)
        near, blocks = near or chain_legs(costs, data.size[0], parameters), tour_blocks(costs, tours)
        move, bridge = np.zeros(4, np.int64), np.zeros(5, np.int64)
        self._chain = Chain(costs, near, blocks, np.empty(m), move, bridge, kept_of(blocks), *room)
        self._parameters = parameters._replace(second=min(parameters.second, near.nodes.shape[1]))
        self._rng = rng
        self._best = self.ring()
        self._leg = float(tours.cost.sum()) / nodes
        self.longest = float(tours.cost.max())

    def advance(self, done: float, kicks: int) -> bool:
        """Kick at the temperature that belongs to `done` in 0..1; return whether the longest tour became shorter."""
        first, last = self._parameters.first, self._parameters.last
        temperature, before = max(TINY, self._leg * first * (last / first) ** done), self.longest
        self.longest = chain_kicks(self._chain, self._best, before, self._rng, kicks, temperature, self._parameters)
        return self.longest < before

    def settle(self, scale: float) -> None:
        """Descend from all nodes, s of the energy in mean legs; `best` and `longest` do not follow."""
        chain = self._chain
        total = total_of(chain.blocks)
        leg, mean = total / chain.queue.size, total / chain.energies.size
        descend_everywhere(chain, self._parameters.gain * leg, self._parameters, Pressure(mean, scale * leg))

    def ring(self) -> Nodes:
        """Return all nodes (N+1,) in the order in which tours are now, the first again at the end."""
        ring = np.empty(self._chain.queue.size + 1, np.int32)
        write_ring(self._chain.blocks, ring)
        return ring

    def best(self) -> Tours:
        """Return the tours whose longest was shortest so far."""
        return tours_of(self._chain.costs, self._best, self._chain.energies.size)
