"""Statistics: whether methods truly differ, or the instances are too few to say so.

The unit is the instance: seeds on one instance are not independent trials of a method, so their median counts once.
"""

from reports.statistics.blocks import blocks
from reports.statistics.bootstrap import bootstrap_interval
from reports.statistics.friedman import friedman
from reports.statistics.pairwise import ALPHA, holm, pairwise, signed_rank

__all__ = ["ALPHA", "blocks", "bootstrap_interval", "friedman", "holm", "pairwise", "signed_rank"]
