"""`workbench report`: make pages and tables from stored runs; compare with an older store."""

from __future__ import annotations

from pathlib import Path

import click

from instances.errors import InputError

FILE = click.Path(path_type=Path, dir_okay=False)


@click.command("report")
@click.argument("folders", metavar="RUNS-DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=FILE, help="The page (.html).")
@click.option("--csv", type=FILE, help="A row a run.")
@click.option("--latex", type=FILE, help="Summary and instances as LaTeX tables.")
@click.option("--markdown", type=FILE, help="Summary and instances as Markdown tables.")
@click.option("--parquet", type=FILE, help="A row a run.")
@click.option("--against", type=click.Path(path_type=Path), help="An older store: better, worse or unchanged?")
@click.option("--fail-on-regression", is_flag=True, help="With --against: exit code 1 where something got worse.")
@click.pass_context
def command(
    context: click.Context,
    folders: tuple[Path, ...],
    out: Path | None,
    csv: Path | None,
    latex: Path | None,
    markdown: Path | None,
    parquet: Path | None,
    against: Path | None,
    fail_on_regression: bool,
) -> None:
    """Report on the runs of one store or several merged, without running anything; prints the summary.

    Placements have a page and a table of their own: OUT-placement.html and CSV-placement.csv beside those of routing
    runs, where there are any.
    """
    from reports import tables
    from reports.compare import compare_stores
    from reports.page import write_report
    from reports.stores import read_stores
    from workbench.placement_publish import publish_placements
    from workbench.publish import print_comparison, print_summary

    if fail_on_regression and against is None:
        raise InputError("--fail-on-regression: needs --against OLD")
    routing_only = {"--latex": latex, "--markdown": markdown, "--parquet": parquet, "--against": against}
    placed = publish_placements(folders, out, csv, [flag for flag, value in routing_only.items() if value])
    if placed is not None:
        for warning in [*placed.warnings, *placed.false]:
            click.echo(warning, err=True)
        if not placed.routing:
            return
    if out:
        report = write_report(folders, out, against=[against] if against else ())
        runs, warnings, comparison = report.runs, report.warnings, report.comparison
    else:
        stores = read_stores(*folders)
        runs, warnings = stores.runs, stores.warnings
        comparison = compare_stores(runs, read_stores(against).runs) if against else None
    writers = (
        (csv, tables.write_csv),
        (latex, tables.write_latex),
        (markdown, tables.write_markdown),
        (parquet, tables.write_parquet),
    )
    for path, write in writers:
        if path:
            write(runs, path)
    for warning in warnings:
        click.echo(warning, err=True)
    print_summary(runs)
    if comparison:
        print_comparison(comparison)
    context.exit(1 if fail_on_regression and comparison and comparison.regressed else 0)
