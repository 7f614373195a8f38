"""`workbench certify`: prove a lower bound and write the proof, for `workbench check` to go through again."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.options import JSON, SECONDS, SEED
from workbench.terminal import print_json, say


@click.command("certify")
@click.argument("instance_file", metavar="INSTANCE", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), help="File of the certificate; NAME.certificate.json.gz if not given."
)
@click.option(
    "--routes", type=click.Path(path_type=Path), help="Routes (.sol) known; without it some are searched for."
)
@click.option(
    "--by",
    type=click.Choice(["tours", "arcs"]),
    help="What the proof is over; arcs from 15 tasks a UAV on if not given, tours below.",
)
@JSON
@click.option("--time-limit", type=SECONDS, default=60.0, show_default=True, help="Seconds of wall clock.")
@click.option("--seed", type=SEED, default=0, show_default=True)
def command(
    instance_file: Path,
    out: Path | None,
    routes: Path | None,
    by: str | None,
    as_json: bool,
    time_limit: float,
    seed: int,
) -> None:
    """Prove how short the longest tour of INSTANCE can be, and write the whole proof: a tree over tours or over arcs.

    Where time is up first the certificate is of the bound reached. `workbench check INSTANCE CERTIFICATE` goes through
    it with code of its own: tours are listed again, bounds computed again.

    \b
    Examples:
      workbench certify a.json --out a.certificate.json.gz --time-limit 30
      workbench check a.json a.certificate.json.gz
    """
    from formulations.limits import Limits
    from formulations.routing.arc_tree import ArcTree
    from formulations.routing.branch_and_price import BranchAndPrice
    from formulations.routing.certifying import certifier, certify
    from instances.certificate import SUFFIX, write_certificate
    from instances.files import read_instance, read_routes

    limits, instance = Limits(time=time_limit), read_instance(instance_file)
    start = None if routes is None else read_routes(routes, instance)
    out = out or Path(f"{instance.name}{SUFFIX}")
    solver = {None: certifier(instance), "tours": BranchAndPrice(), "arcs": ArcTree()}[by]
    solver.prepare(instance)
    certificate = certify(instance, limits=limits, seed=seed, start=start, solver=solver)
    write_certificate(out, certificate)
    objective, bound = certificate.objective, certificate.bound
    gap = None if objective is None else (objective - bound) / objective
    if as_json:
        about = {"instance": instance.name, "digest": instance.digest, "objective": objective, "bound": bound}
        print_json({**about, "gap": gap, "nodes": len(certificate.nodes), "out": out})
        return
    known = "no routes known" if gap is None else f"routes {objective:.6g} s, gap {gap:.2%}"
    say(f"{out}: bound {bound:.6g} s, {known}, {len(certificate.nodes)} cases")
