"""The Irregular Terrain Model against NTIA's published point-to-point vectors, and the time of a map.

    python tests/benchmarks/irregular_terrain.py [--vectors DIR]

DIR holds `p2p.csv` and `pfls.csv` of NTIA's reference implementation (github.com/NTIA/itm, folder tests). Bars: every
vector within 0.01 dB; a map of 200 × 200 in at most 1 s.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from instances.environment.itm.loss import MODES, Propagation, path_loss
from instances.environment.itm.variability import CLIMATES
from instances.environment.propagation import radio_map
from instances.environment.radio import RadioSource
from instances.environment.terrain import mountains


def vectors(folder: Path) -> None:
    """Print each vector's published and computed loss."""
    with (folder / "p2p.csv").open() as table, (folder / "pfls.csv").open() as profiles:
        for case, line in zip(csv.DictReader(table), profiles, strict=True):
            row = np.array(line.split(","), dtype=float)
            code = int(case["mdvar"])
            assumed = Propagation(
                permittivity=float(case["epsilon"]),
                conductivity=float(case["sigma"]),
                refractivity=float(case["N_0"]),
                vertical=case["pol"] == "1",
                climate=CLIMATES[int(case["climate"]) - 1],
                time=float(case["time"]) / 100,
                location=float(case["location"]) / 100,
                situation=float(case["situation"]) / 100,
                mode=MODES[code % 10],
                location_variability=code // 10 % 2 == 0,
                situation_variability=code < 20,
            )
            heights = (float(case["h_tx__meter"]), float(case["h_rx__meter"]))
            loss = path_loss(row[2:], row[1], *heights, float(case["f__mhz"]) * 1e6, assumed)
            published = float(case["A__db"])
            verdict = "ok" if abs(loss - published) <= 0.01 else "MISSED"
            print(f"published {published:7.2f} dB, computed {loss:9.4f} dB, bar 0.01 dB: {verdict}")


def map_time() -> None:
    """Print the CPU time of a 200 × 200 map after compilation, for each model."""
    source, bounds, ground = RadioSource((10e3, 10e3)), (0.0, 0.0, 20e3, 20e3), mountains()
    for model in ("diffraction", "itm"):
        radio_map(source, bounds, ground, model=model, cells=10)
        began = time.process_time()
        radio_map(source, bounds, ground, model=model, cells=200)
        print(f"{model}: {time.process_time() - began:.2f} s CPU for 201 × 201 nodes (bar 1 s)")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vectors", type=Path)
    folder = parser.parse_args().vectors
    if folder:
        vectors(folder)
    map_time()
