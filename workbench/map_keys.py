"""Keys of missions and studies alike: what a placement maximises, and the maps of what counts and what was known."""

from __future__ import annotations

from typing import Annotated, Literal

from instances.declared.types import FileName, about

Criterion = Literal["b", "a", "ig", "j"]
MAXIMISED = (
    "what is maximised: information (b both noisy, a latent tests, ig information gain), or j, how far the "
    "weighted mean variance falls"
)
"""What each criterion is, in words."""
Weights = Annotated[
    FileName | None,
    about("how much places count, from a file: GeoTIFF, polygons or CSV; take criterion j", example="roads.geojson"),
]
PriorSd = Annotated[
    FileName | None,
    about("a map in place of signal_sd, which counts where no polygon lies", example="unsure.tif"),
]
