"""Named cases: what the fuzzer and people before it have found, one line each, replayed by `test_cases`."""

from __future__ import annotations

import gzip
import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.fuzz.targets import TARGETS

DIGITS = "9" * 5000
NESTED = "[" * 100_000
LONG = "9" * 400
Content = Callable[[bytes], bytes]


@dataclass(frozen=True)
class Named:
    """One case: the target, the file that is changed and how, or what is done in the folder, or the command line."""

    name: str
    target: str
    file: str = ""
    content: Content | None = None
    prepare: Callable[[Path], None] | None = None
    more: tuple[str, ...] = ()

    @property
    def args(self) -> tuple[str, ...]:
        """The command line: the target's, and `more` behind it."""
        return (*TARGETS[self.target].args, *self.more)


def _as(text: str) -> Content:
    """Return what makes a file hold `text`."""
    return lambda data: text.encode("utf-8", "surrogatepass")


def _with(old: str, new: str) -> Content:
    """Return what replaces the first `old`, a pattern, by `new`."""

    def change(data: bytes) -> bytes:
        changed, count = re.subn(old, lambda match: new, data.decode(), count=1)
        assert count, old
        return changed.encode("utf-8", "surrogatepass")

    return change


def _table(edit: Callable[[Any], object]) -> Content:
    """Return what edits a JSON file as a table."""

    def change(data: bytes) -> bytes:
        table = json.loads(data)
        edit(table)
        return json.dumps(table).encode()

    return change


def _squeezed(inner: Content) -> Content:
    return lambda data: gzip.compress(inner(gzip.decompress(data)), 1)


def _bomb(data: bytes) -> bytes:
    """Return gzip that opens to 100 MB of nothing."""
    return gzip.compress(bytes(100 << 20), 1)


def _fifo(pattern: str) -> Callable[[Path], None]:
    """Return what puts a FIFO in place of a file."""

    def change(folder: Path) -> None:
        path = next(iter(sorted(folder.glob(pattern))))
        path.unlink()
        os.mkfifo(path)

    return change


def _linked(name: str, to: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        (folder / name).unlink()
        (folder / name).symlink_to(to)

    return change


def _paths(name: str, inner: Content) -> Named:
    return Named(f"paths: {name}", "paths", "planned.paths.json.gz", _squeezed(inner))


def _first_number(key: str, value: Any) -> Content:
    def edit(table: Any) -> None:
        rows = table[key]
        if isinstance(rows[0], list):
            rows[0][0] = value
        else:
            rows[len(rows) // 2] = value

    return _table(edit)


RUN = {
    "routing": "routing/*/greedy*s1*.json",
    "placement": "placement/*/greedy*.json",
    "moving-cost": "moving-cost/*/d*.json",
    "survey": "survey/*/m*.json",
}


def _run(name: str, command: str, problem: str, content: Content) -> Named:
    return Named(f"{command} {problem}: {name}", f"{command} {problem}", RUN[problem], content)


def _study(name: str, problem: str, old: str, new: str) -> Named:
    return Named(f"study: {name}", f"study {problem}", f"{problem}.toml", _with(old, new))


def _value(name: str, *more: str) -> Named:
    return Named(f"value: {name} {' '.join(more)[:40]}", f"values of {name}", more=more)


READ = (
    Named("paths: corrupt zlib", "paths", "planned.paths.json.gz", lambda data: data[:40] + b"\xff" * 20 + data[60:]),
    Named("paths: cut", "paths", "planned.paths.json.gz", lambda data: data[:100]),
    _paths("nested", _as(NESTED)),
    _paths("a point far away", _first_number("points", 1e308)),
    _paths("a coordinate of 2e9", _first_number("points", 2e9)),
    _paths("negative repeats", _first_number("offsets", -5)),
    _paths("repeats without end", _first_number("offsets", 10**12)),
    _paths("another's scenario", _table(lambda table: table.update(scenario="../../../../etc/passwd"))),
    _paths("a scenario that is a device", _table(lambda table: table.update(scenario="zero"))),
    Named("paths: a bomb", "paths", "planned.paths.json.gz", _bomb),
    Named("instance: a bomb", "instance json.gz", "small.json.gz", _bomb),
    Named("instance: 5,000 digits", "instance json", "small.json", _with(r'"n_tasks": \d+', f'"n_tasks": {DIGITS}')),
    Named("instance: a key that is no text", "instance json", "small.json", lambda data: b'{"\xf0' + data[2:]),
    Named("instance: nested", "instance json", "small.json", _as(NESTED)),
    Named("instance: a lone surrogate", "instance json", "small.json", _with('"name": "[^"]*"', r'"name": "\ud800"')),
    Named("instance: a link to a device", "instance json", prepare=_linked("small.json", "zero")),
    Named("instance: a FIFO", "instance json", prepare=_fifo("small.json")),
    Named("instance: a link to itself", "instance json", prepare=_linked("small.json", "small.json")),
    Named("tsplib: a dimension of 5,000 digits", "instance tsp", "small.tsp", _with("N: 4", f"N: {DIGITS}")),
    Named("tsplib: a colon among coordinates", "instance vrp", "small.vrp", _with("1 0 0", "1 0 'a:b'")),
    Named("tsplib: coordinates of 1e308", "instance tsp", "small.tsp", _with("3 4", "1e308 -1e308")),
    Named("region: NaN", "region", "region.geojson", _with(r"6000\.0", "NaN")),
    Named("region: 1e308", "region", "region.geojson", _with(r"6000\.0", "1e308")),
    Named("region: nested", "region", "region.geojson", _as(NESTED)),
    Named("test points: lone carriage returns", "test points", "tests.csv", lambda data: data.replace(b"\n", b"\r")),
    Named("test points: a long value", "test points", "tests.csv", _with("4000", "[" * 20_000)),
    Named("test points: 5,000 digits", "test points", "tests.csv", _with("4000", DIGITS)),
    Named("wind: cells of 1e-317 m", "wind .asc", "ninja_vel.asc", _with("cellsize 1300", "cellsize 1e-317")),
    Named("wind: units are a number", "scenario ninja", "ninja.toml", _with('"mph"', "5.5")),
    Named("wind: units are a list", "scenario ninja", "ninja.toml", _with('"mph"', "[1]")),
    Named("wind: nodes without end", "wind .asc", "ninja_vel.asc", _with("ncols 6", "ncols 99999999999")),
)  # fmt: skip
STORES = (
    *(_run("5,000 digits", command, problem, _with(r'"seed": \d+', f'"seed": {DIGITS}'))
      for command in ("status", "check", "report") for problem in RUN),
    *(_run("400 digits", command, problem, _with('"objective": [-0-9.e]+', f'"objective": {LONG}'))
      for command in ("check", "report") for problem in RUN),
    *(_run("nested", command, "routing", _as(NESTED)) for command in ("status", "check", "report")),
    *(_run(f"without {key}", command, "placement", _table(lambda run, key=key: run.pop(key)))
      for command in ("check", "report") for key in ("time_limit", "mutual_information")),
    _run("a table for a schema", "status", "routing", _with('"schema": 1', '"schema": {}')),
    _run("a table for a problem", "status", "routing", _with('"problem": "routing"', '"problem": {}')),
    _run("an infinite tour", "check", "routing", _with(r'"tour_costs": \[[^\]]*\]', '"tour_costs": [Infinity, 0]')),
    Named("status: a nested study", "status routing", "routing/study.json", _as(NESTED)),
    Named("resume: a nested study", "resume", "routing/study.json", _as(NESTED)),
    *(Named(f"{command}: a FIFO in a store", f"{command} routing", prepare=_fifo(RUN["routing"]))
      for command in ("status", "check", "report")),
)  # fmt: skip
STUDIES = (
    _study("a device for a region", "placement", r"\[\"region.geojson\"\]", '"zero"'),
    _study("a FIFO for a region", "placement", r"\[\"region.geojson\"\]", '"fifo"'),
    _study("a device for tests", "placement", "tests.csv", "zero"),
    _study("signal_sd is a text", "placement", r"signal_sd = 20\.0", 'signal_sd = "text"'),
    _study("test_noise_sd is a list", "placement", r"signal_sd = 20\.0", "test_noise_sd = [0]"),
    _study("signal_sd of 400 digits", "placement", r"signal_sd = 20\.0", f"signal_sd = {LONG}"),
    _study("max_tasks is a text", "routing", "max_tasks = 9", 'max_tasks = "."'),
    _study("tasks are a text", "placement", r"tasks = \[2\]", 'tasks = "."'),
    _study("max_tasks of placement is a text", "placement", 'name = "greedy"', 'name = "greedy"\nmax_tasks = "."'),
    _study("a milliard seeds", "routing", "seeds = 2", "seeds = 1000000000"),
    _study("a seed of 5,000 digits", "routing", "seeds = 2", f"seeds = [{DIGITS}]"),
    _study("a time limit of 400 digits", "routing", "time_limit = 2", f"time_limit = {LONG}"),
    _study("iterations of 400 digits", "routing", "time_limit = 2", f"time_limit = 2\niterations = {LONG}"),
    _study("nested", "routing", "seeds = 2", f"seeds = {NESTED}"),
    _study("keys without end", "routing", "seeds = 2", f"{'a.' * 50_000}a = 2"),
    _study("a name that climbs", "routing", "seeds = 2", 'seeds = 2\nname = "../../../x"'),
    _study("a problem of 5,000 digits", "placement", '"placement"', f'"{DIGITS}"'),
    _study("an option of 5,000 digits", "moving-cost", "samples", DIGITS),
    *(_study(f"an option {value}", "routing", r'variant = \[[^\]]*\]', f"variant = {value}")
      for value in ("nan", "inf", "1979-05-27", '"[/b]"', '"\\u001b[31m"', "{}", DIGITS)),
    *(_study(f"solver {name}", "routing", '"greedy"', f'"{name}"')
      for name in ("builtins:exit", "os:abort", "signal:pause", "os:fork", ":x", "json:", "no_such:X", "x" * 10_000)),
)  # fmt: skip
VALUES = (
    *(_value("bound", "--time-limit", value) for value in ("inf", "1e308", "nan", LONG)),
    *(_value("compare", "--seeds", value) for value in ("99999999999999999999", "1000000000", DIGITS)),
    *(_value("compare", flag, "9" * 400) for flag in ("--shard", "--jobs", "--threads", "--retry")),
    _value("place", "--noise-sd", "1e308"),
    _value("place", "--noise-sd", "1e-320"),
    _value("place", "--length-scale", "1e-320"),
    _value("place", "--length-scale", "1e308"),
    _value("place", "--tasks", "99999999999999999999"),
    _value("place", "--study", "n=1..99999999999999999999"),
    _value("place", "--tests", "99999x99999"),
    _value("generate", "--count", "99999999999999999999"),
    _value("generate", "--tasks", "99999999999999999999"),
    _value("generate", "--set", "size=1e308"),
    _value("generate", "--set", f"x={DIGITS}"),
    _value("solve", "--option", f"variant={NESTED[:20_000]}"),
    _value("solve", "--time-limit", "1e308"),
    _value("solve", "--threads", "99999999999999999999"),
    *(Named(f"value: {command} of a long path", f"values of {command}", more=("x" * 10_000,))
      for command in ("status", "check", "report", "costs", "mission", "convert")),
)  # fmt: skip
CASES = (*READ, *STORES, *STUDIES, *VALUES)
