"""Bridges: moves of the chained search that are not sequential, double bridges that save something.

Two legs of a tour are exchanged for two that close what is between them to a ring by itself, and save something; that
ring is opened at a third leg and put in where a fourth was, on any tour, either way round. Neither exchange is a move
by itself, and sequential moves (chain_moves.py) do not come to both (Lin & Kernighan 1973; Helsgaun, EJOR 126, 2000).
What tours of rl5915_3 were longer than better ones was half in 20 exchanges of two legs that no move made (by script).
"""

from __future__ import annotations

from formulations.routing.search.chain_moves import Chain, ChainParameters
from formulations.routing.search.costs import leg
from formulations.routing.search.ring_energy import Pressure, gain_between
from formulations.routing.search.tour_blocks import leg_at
from instances.kernels import njit


@njit(cache=True, nogil=True)
def _open(chain: Chain, low: int, high: int, saved: float, top: float, pressure: Pressure) -> float:
    """Write the best bridge that closes low+1..high to a ring, which saves `saved` [s], if it is worth more than `top`.

    Return what the best is worth [s].
    """
    near, near_cost = chain.near
    blocks, costs = chain.blocks, chain.costs
    order, position, sums, a = blocks.order, blocks.position, blocks.sums, low >> blocks.bits
    less = saved + sums[high] - sums[low + 1] + leg(costs, 0, order[high], order[low + 1])
    for i in range(low + 1, high):
        for right in range(2):
            v, w = order[i + right], order[i + 1 - right]
            for j in range(near.shape[1]):
                u, so_far = near[v, j], saved + sums[i + 1] - sums[i] - near_cost[v, j]
                if u < 0 or so_far <= 0.0:
                    break
                if low < position[u] <= high:
                    continue
                for before in range(2):
                    e = leg_at(blocks, position[u], before)
                    if e in (low, high):
                        continue
                    worth = so_far + sums[e + 1] - sums[e] - leg(costs, 0, w, order[e + 1 - before])
                    if e >> blocks.bits != a:
                        worth = gain_between(blocks, chain.energies, a, e >> blocks.bits, less, worth, pressure)
                    if worth > top:
                        top, bridge = worth, chain.bridge
                        bridge[0], bridge[1], bridge[2], bridge[3] = low, i, high, e
                        bridge[4] = right == before
    return top


@njit(cache=True, nogil=True)
def best_bridge(chain: Chain, t1: int, least: float, parameters: ChainParameters, pressure: Pressure) -> float:
    """Write the best bridge that removes a leg of t1 and is worth more than `least` [s] to `chain.bridge`.

    Return what it is worth, `least` where there is none.
    """
    near, near_cost = chain.near
    blocks = chain.blocks
    order, position, sums = blocks.order, blocks.position, blocks.sums
    top = least
    for s1 in range(2):
        e1 = leg_at(blocks, position[t1], s1)
        t2 = order[e1 + 1 - s1]
        for j in range(near.shape[1]):
            t3 = near[t2, j]
            first = sums[e1 + 1] - sums[e1] - near_cost[t2, j]
            if t3 < 0 or first <= 0.0:
                break
            e2 = leg_at(blocks, position[t3], s1)
            low, high = min(e1, e2), max(e1, e2)
            if low >> blocks.bits != high >> blocks.bits or not 2 < high - low <= parameters.bridged:
                continue
            saved = first + sums[e2 + 1] - sums[e2] - leg(chain.costs, 0, t1, order[e2 + 1 - s1])
            if saved > least:
                top = _open(chain, low, high, saved, top, pressure)
    return top
