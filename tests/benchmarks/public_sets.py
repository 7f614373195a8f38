"""The public instances for the scripts here: the option --benchmarks, and the sets with their best known values.

formulations/routing/README.md says which sets they are and how the folder is laid out.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

from instances import Instance
from instances.files import read_instance

FOLDER = Path(__file__).parents[3] / "shared" / "benchmarks"
"""Where they are looked for: ../shared/benchmarks beside the checkout."""


def add_option(parser: argparse.ArgumentParser) -> None:
    """Let a script be told where the public instances are."""
    parser.add_argument(
        "--benchmarks",
        type=Path,
        default=FOLDER,
        metavar="DIR",
        help="the public instances; default ../shared/benchmarks beside the checkout",
    )


def public(
    folder: Path, *sets: str, most: int | None = None, only: tuple[str, ...] = ()
) -> list[tuple[Instance, float]]:
    """Return the instances of at most `most` tasks that have a best known value, with it; `only` names some.

    Ends the script with a sentence where the folder is not there, or nothing in it that was asked for.
    """
    if not folder.is_dir():
        raise SystemExit(f"The public instances are not there ({folder}); say where with --benchmarks DIR.")
    with (folder / "best_known.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["set"] in sets and row["best_known"]]
    found = [
        (read_instance(folder / row["set"] / f"{row['instance']}.mdm"), float(row["best_known"]))
        for row in rows
        if (most is None or int(row["n_tasks"]) <= most) and (not only or row["instance"] in only)
    ]
    if not found:
        asked = f" called {', '.join(only)}" if only else ""
        raise SystemExit(f"No instance{asked} with a best known value is in {' or '.join(sets)} of {folder}.")
    return found
