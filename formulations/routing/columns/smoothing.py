"""Smoothing: how far from the best duals known towards the master's the next ones lie.

The master's duals jump about while columns are few, and prices half-way from the best known (Wentges, "Weighted
Dantzig–Wolfe decomposition for linear mixed-integer programming", 1997) find better columns and bounds. Once the
master's duals are those of the relaxation, half-way only halves the distance from round to round. So the share of the
way follows the slope: where the Lagrangian bound at the prices just tried rises towards the master's duals, the next
prices lie nearer to these, else nearer to the best known (Pessoa, Sadykov, Uchoa, Vanderbeck, "Automation and
combination of linear-programming based stabilization techniques in column generation", INFORMS J. Comput. 30, 2018).
It stays half-way where duals are to stay near some that are given, and over walks: the more different walks are made,
the more is learnt to remember.
"""

from __future__ import annotations

from collections.abc import Mapping

from formulations.routing.columns.master import Master
from formulations.routing.columns.pricing import Duals, Priced

HALF_WAY = 0.5
_NEARER, _BACK = 0.5, 0.7
"""Part of the way left that is gone where the bound rises, and of the way gone that is kept where it does not."""


def adapted(share: float, priced: Mapping[int, Priced], tried: Duals, master: Master, at_master: Duals) -> float:
    """Return the share of the way to the master's duals for the next prices, after `share` led to those `tried`.

    The slope is that of the bound with the best columns at these prices: what they come to at either duals.
    """
    columns = [priced[k].columns[0] for k in master.first if priced[k].columns]
    here, there = (duals.offset + float(duals.values(columns).sum()) for duals in (tried, at_master))
    return share + _NEARER * (1 - share) if there > here else _BACK * share
