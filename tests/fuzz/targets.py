"""Targets: a command line, the files it reads, and what it may write. All paths are those of the corpus."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import click

from tests.fuzz import nasty
from workbench.cli import commands


@dataclass(frozen=True)
class Target:
    """One command line.

    files : patterns of the files that are changed, one a case; without any, a value of the command line is.
    beside : patterns of what else it reads. outputs : beginnings of paths it may write.
    sealed : whether the stamp of a changed product is made anew, so that a mission takes it for its own.
    """

    name: str
    args: tuple[str, ...]
    files: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    sealed: bool = False


def _reads(name: str, line: str, *files: str, beside: str = "", outputs: str = "", sealed: bool = False) -> Target:
    return Target(name, tuple(line.split()), files, tuple(beside.split()), tuple(outputs.split()), sealed)


GROUND = "zones.geojson dem.asc wind.nc ninja_*.asc"
COSTS = "--method dijkstra --option samples=60 --out new.json"
PRODUCTS = tuple(f"mission/{name}" for name in (
    "1-environment/[efr]*", "1-environment/sc*", "2-place/[pt]*", "3-costs/[i]*", "4-routes/r*", "5-flight/[fru]*"
))  # fmt: skip
"""What stages start from, without the stamps."""
FILES = (
    *(_reads(f"instance {e}", f"convert small.{e} new.json", f"small.{e}", outputs="new.json")
      for e in ("json", "json.gz", "atsp", "tsp", "mtsp", "mdm", "vrp")),
    *(_reads(f"routes .{e}", f"check small.json small.{e}", f"small.{e}", beside="small.json")
      for e in ("sol", "tour")),
    _reads("paths", "check planned.paths.json.gz", "planned.paths.json.gz",
           beside="planned.json sum.toml zones.geojson"),
    _reads("planned instance", "check planned.paths.json.gz", "planned.json",
           beside="planned.paths.json.gz sum.toml zones.geojson"),
    *(_reads(f"scenario {e}", f"costs {e}.toml {COSTS}", f"{e}.toml", beside=GROUND,
             outputs="new.json new.paths.json.gz")
      for e in ("grid", "ninja", "sum", "terrain")),
    _reads("wind .nc", f"costs grid.toml {COSTS}", "wind.nc", beside=f"grid.toml {GROUND}",
           outputs="new.json new.paths.json.gz"),
    _reads("wind .asc", f"costs ninja.toml {COSTS}", "ninja_*.asc", beside=f"ninja.toml {GROUND}",
           outputs="new.json new.paths.json.gz"),
    _reads("terrain .asc", f"costs terrain.toml {COSTS}", "dem.asc", beside=f"terrain.toml {GROUND}",
           outputs="new.json new.paths.json.gz"),
    _reads("terrain .tif", f"costs geotiff.toml {COSTS}", "dem.tif", beside=f"geotiff.toml {GROUND}",
           outputs="new.json new.paths.json.gz"),
    *(_reads(f"field .{e}", f"mission field-{e}.toml --out new --stage environment", f"field.{e}",
             beside=f"field-{e}.toml zones.geojson", outputs="new") for e in ("csv", "nc")),
    _reads("no-fly zones", f"costs sum.toml {COSTS}", "zones.geojson", beside=f"sum.toml {GROUND}",
           outputs="new.json new.paths.json.gz"),
    _reads("region", "place region.geojson --tasks 2 --tests 3x3 --method greedy --no-certificate", "region.geojson"),
    _reads("test points", "place --tasks 2 --tests tests.csv --method greedy --no-certificate", "tests.csv"),
    _reads("study routing", "compare routing.toml --dry-run", "routing.toml", beside="small.json"),
    _reads("study placement", "compare placement.toml --dry-run", "placement.toml", beside="region.geojson tests.csv"),
    _reads("study moving-cost", "compare moving-cost.toml --dry-run", "moving-cost.toml", beside=f"sum.toml {GROUND}"),
    _reads("study survey", "compare survey.toml --dry-run", "survey.toml", beside="field.csv"),
    *(_reads(f"{command} {problem}", f"{command} {problem}{more}", f"{problem}/**/*.*", outputs="new.")
      for problem in ("routing", "placement", "moving-cost", "survey")
      for command, more in (("status", ""), ("check", ""), ("report", " --csv new.csv"))),
    *(_reads(f"page {problem}", f"report {problem} --out new.html", f"{problem}/**/*.*", outputs="new.html")
      for problem in ("routing", "placement", "moving-cost", "survey")),
    _reads("resume", "compare routing.toml --out routing --no-report --dry-run",
           "routing/**/*.json*", beside="routing.toml small.json"),
    *(_reads(f"import {e}", f"import others.{e} --into new", f"others.{e}", beside="small.json small.sol",
             outputs="new") for e in ("csv", "parquet")),
    _reads("import sol", "import small.sol --into new --instance small.json --solver X --elapsed 1 --time-limit 2",
           "small.sol", beside="small.json", outputs="new"),
    _reads("paper", "paper routing --out new", "routing/**/*.*", outputs="new"),
    _reads("slurm", "compare small.json --solvers greedy --time-limit 1 --slurm slurm.toml --dry-run", "slurm.toml",
           beside="small.json"),
    _reads("mission file", "mission mission.toml --out new --stage environment", "mission.toml", beside="zones.geojson",
           outputs="new"),
    _reads("mission stamps", "mission mission.toml --out mission --stage map", "mission/*/stamp.json",
           beside="mission.toml zones.geojson mission/**/*", outputs="mission/"),
    *(_reads(f"products for {stage}", f"mission mission.toml --out mission --stage {stage}", *PRODUCTS,
             beside="mission.toml zones.geojson mission/**/*", outputs="mission/", sealed=True)
      for stage in ("place", "costs", "routes", "flight", "map")),
    _reads("products for report", "mission mission.toml --out mission --stage report", *PRODUCTS, "mission/6-map/[mt]*",
           "mission/7-compare/[ct]*",
           beside="mission.toml zones.geojson mission/**/*", outputs="mission/", sealed=True),
)  # fmt: skip


def _typed(line: str, *, beside: str = "") -> Target:
    words = tuple(line.split())
    return Target(f"values of {words[0]}", words, (), tuple(beside.split()), ("",))  # a value may name any new file


VALUES = (
    _typed("solve small.json --solver greedy --time-limit 0.2", beside="small.json small.sol"),
    _typed("generate uniform --tasks 3 --depots 2 --set wind=shear --out new"),
    _typed("bound small.json --routes small.sol --time-limit 0.2", beside="small.json small.sol"),
    _typed("place --tasks 2 --tests 3x3 --method greedy --no-certificate --length-scale 4000", beside="tests.csv"),
    _typed("compare small.json --solvers greedy --time-limit 0.2 --dry-run", beside="small.json"),
    _typed("check small.json small.sol", beside="small.json small.sol"),
    _typed("report routing --csv new.csv", beside="routing/**/*"),
    _typed("status routing", beside="routing/**/*"),
    _typed(f"costs sum.toml {COSTS}", beside=f"sum.toml {GROUND}"),
    _typed("mission mission.toml --out new --stage environment", beside="mission.toml zones.geojson"),
    _typed("convert small.json new.atsp", beside="small.json"),
    _typed(
        "import small.sol --into new --instance small.json --solver X --elapsed 1 --time-limit 2",
        beside="small.json small.sol",
    ),
    _typed("solvers"),
    _typed("families"),
)
TARGETS = {target.name: target for target in (*FILES, *VALUES)}
"""Name → target."""


def retyped(rng: Random, args: tuple[str, ...]) -> list[str]:
    """Return a command line with one or two nasty values: an argument, an option's, or a further option."""
    command, line = args[0], list(args[1:])
    group = click.Context(commands)
    found = commands.get_command(group, command)
    assert found is not None
    options = [param for param in found.params if isinstance(param, click.Option) and not param.is_flag]
    for _ in range(rng.choice((1, 1, 2))):
        value = rng.choice((*nasty.NUMBERS, *nasty.WORDS, *_SPECIAL.get(command, ())))
        at = rng.randrange(len(line) + 1)
        if at < len(line) and rng.random() < 0.5:
            line[at] = value
        elif options:
            line += [rng.choice(options).opts[-1], value]
    kept = [] if command != "compare" or "--dry-run" in line else ["--dry-run"]  # not a study of anything for real
    # no process can be given a zero byte, and bytes that are no text arrive as low surrogates
    return [command, *(word.replace("\x00", "").replace("\ud800", "\udcff") for word in (*line, *kept))]


_SPECIAL = {
    "solve": ("variant=nearest", "variant=[1]", "x=nan", "variant=\x1b[31m", "threads=" + "9" * 5000,
              "x=" + "[" * 20_000),
    "generate": ("size=1e308", "size=nan", "size=-1", "wind=vortices", "wind=none", "x=" + "9" * 5000, "size=[1, 2]"),
    "place": ("n=1..3", "n=5..1", "n=1.." + "9" * 30, "3x3", "99999x99999", "0x0", "1e-320", "1,2,3", "ig"),
    "compare": ("1/2", "0/0", "1/" + "9" * 5000, "killed", "stale", "tcp://nowhere:1", "greedy,greedy", ",",
                "ga", "quick", "misbehaving:Crashes"),
    "costs": ("samples=1", "samples=-1", "samples=" + "9" * 5000, "x=1", "samples=nan", "samples=[1]"),
    "mission": ("environment", "place", "report", "routes"),
}  # fmt: skip
"""Command → values that its options nearly take."""
