"""`workbench record`: keep a record book of best known values with the runs of stores."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from instances.errors import InputError
from workbench.options import JSON

if TYPE_CHECKING:
    import pandas as pd

    from instances.record_book import RecordBook
    from reports.stores import Stores


@click.command("record")
@click.argument("folders", metavar="RUNS-DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--book", "folder", required=True, metavar="DIR", type=click.Path(path_type=Path), help="The record book."
)
@click.option("--add", is_flag=True, help="Take instances too that the book does not have.")
@JSON
@click.pass_context
def command(context: click.Context, /, folders: tuple[Path, ...], folder: Path, add: bool, as_json: bool) -> None:
    """Enter into the record book DIR what stored runs know better; nothing in it ever gets worse.

    The book is DIR/best_known.csv, and DIR/tours.json with the routes of the values found here. Routes are costed
    again; imported ones count alike. A bound counts where the run is ours and no run's routes refute it. What
    contradicts the book is said and left out, with exit code 1.

    \b
    Examples:
      workbench record runs/mine --book records --add
      workbench record runs/mine runs/yours --book records --json
    """
    from instances.record_book import read_book
    from reports.stores import read_stores
    from workbench.settings import make_folder
    from workbench.terminal import print_json, say

    book, stores = read_book(folder), read_stores(*folders)
    changed, problems = _entered(book, stores, add)
    if changed:
        make_folder(folder)
        book.write(folder)
    for sentence in (*stores.warnings, *problems):
        say(sentence, err=True)
    if as_json:
        print_json({"book": folder, "instances": len(book.entries), "changed": changed, "problems": problems})
    else:
        for sentence in changed:
            say(sentence)
        say(
            f"{folder}: {len(book.entries)} instances, " + (f"{len(changed)} changes" if changed else "nothing changed")
        )
    context.exit(1 if problems else 0)


def _entered(book: RecordBook, stores: Stores, add: bool) -> tuple[list[str], list[str]]:
    """Offer the book the best routes and the highest bound of every instance; return changes and contradictions."""
    from reports.proofs import believed_bounds

    changed, problems = [], []
    for digest, runs in stores.runs.groupby("digest", sort=False):
        best = runs[runs["recomputed"].notna()].sort_values("recomputed", kind="stable").head(1)
        bounds = believed_bounds(runs)[runs["proves"].fillna(False).astype(bool) & ~_foreign(runs)]
        for offer in ("routes", "bound"):
            try:
                if offer == "bound" and bounds.notna().any():
                    said = book.raise_bound(str(digest), float(bounds.max()))
                elif offer == "routes" and len(best):
                    said = _offered(book, stores, best.iloc[0], add)
                else:
                    continue
            except InputError as error:
                problems.append(str(error))
            else:
                changed += [said] if said else []
    return changed, problems


def _foreign(runs: pd.DataFrame) -> pd.Series:
    return runs["foreign"].fillna(False).astype(bool)


def _offered(book: RecordBook, stores: Stores, run: pd.Series, add: bool) -> str:
    """Offer the book the routes of one run."""
    from instances import as_routes
    from instances.files import read_instance

    instance = read_instance(stores.instance_files[run["digest"]])
    return book.offer(instance, as_routes(run["routes"]), f"found here by {run['method']}", add=add)
