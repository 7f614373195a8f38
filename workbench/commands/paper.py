"""`workbench paper`: tables, figures and references of stored runs for LaTeX."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from instances.errors import InputError
from workbench.options import JSON

if TYPE_CHECKING:
    from reports.paper.document import Cited


@click.command("paper")
@click.argument("folders", metavar="RUNS-DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=click.Path(path_type=Path), help="Folder of the paper.")
@JSON
@click.pass_context
def command(context: click.Context, /, folders: tuple[Path, ...], out: Path, as_json: bool) -> None:
    """Write what the runs of one store, or of several, show for a paper in LaTeX; nothing is run.

    \b
      DIR/tables/*.tex     method by size: gap, time, proofs (booktabs, siunitx)
      DIR/figures/*.pdf    the figures of the report
      DIR/references.bib   what to cite for every method that ran
      DIR/main.tex         shows them all

    Tables and figures are of routing runs; methods of all problems are cited. Exit code 1 where files are damaged;
    they are named and left out.

    \b
    Examples:
      workbench paper runs/mine --out paper
      cd paper && pdflatex main && bibtex main && pdflatex main && pdflatex main
    """
    from instances.disk import write_aside
    from reports.paper.document import paper_files
    from reports.record import study_title
    from reports.stores import read_stores
    from workbench.settings import make_folder
    from workbench.terminal import print_json, say

    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: is no folder")
    stores = read_stores(*folders)
    methods = _methods(folders)
    if not methods:
        first = f" ({stores.warnings[0]})" if stores.warnings else ""
        raise InputError(f"{', '.join(map(str, folders))}: holds no run that can be read{first}")
    files = paper_files(study_title(folders), stores.runs, stores.claims, methods)
    for name, content in files.items():
        make_folder((out / name).parent)
        write_aside(out / name, content)
    for sentence in stores.warnings:
        say(sentence, err=True)
    uncited = [method.name for method in methods if not method.keys]
    if as_json:
        cited = {method.name: list(method.keys) for method in methods}
        print_json({"files": [str(out / name) for name in files], "cited": cited})
    else:
        click.echo("\n".join(str(out / name) for name in files))
        if uncited:
            say(f"no source is known of {', '.join(uncited)}: cite what they are", err=True)
    context.exit(1 if stores.damaged else 0)


def _methods(folders: tuple[Path, ...]) -> list[Cited]:
    """Return every method that has run, in the order of the registries; those of others come last, without a source."""
    from reports.paper.document import Cited
    from reports.stores import problems_in, read_runs
    from workbench.problems import PROBLEMS

    found: dict[str, Cited] = {}
    for problem in problems_in(*folders):
        methods: Any = PROBLEMS.load(problem).methods
        runs = read_runs(*folders, problem=problem)[0].values()
        ran = {run.solver: run.foreign for run in runs}
        for name in [*(name for name in methods.built_in if name in ran), *sorted(set(ran) - set(methods.built_in))]:
            about = methods.built_in[name][1] if name in methods.built_in else "of others"
            found.setdefault(f"{problem} {name}", Cited(name, about, methods.sources.get(name, ())))
    return list(found.values())
