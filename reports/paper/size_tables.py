"""Size tables: a row a method, a column a size, as LaTeX (packages booktabs and siunitx) aligned at the decimal point.

What is printed decides what is best: equal digits are equally good, and only methods that ran on all instances of a
size, and found routes in all their runs there, are compared.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd

from reports import numbers
from reports.metrics.scores import banded, scores
from reports.tex import tex

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Measure:
    """What a table tells.

    key : of the scores. write : a value as LaTeX. best : which of the values printed is; None for no mark. everywhere :
    what all values are where the table is not worth its place.
    """

    key: str
    write: Callable[[float], str]
    best: Callable[[list[float]], float] | None
    caption: str
    everywhere: float | None = None


def _gap(value: float) -> str:
    return f"{100 * value:.2f}"


def _time(value: float) -> str:
    if 0 < value < 0.0005:
        return "$<$\\,0.001"
    digits = 0 if value >= 100 else 1 if value >= 10 else 2 if value >= 0.1 else 3
    return f"{value:.{digits}f}"


def _share(value: float) -> str:
    return f"{100 * value:.0f}"


MEASURES = {
    "gap": Measure("gap_found", _gap, min, r"Mean gap to the best routes found [\%], over the runs that found routes."),
    "time": Measure("time", _time, min, "Time of a run [s], shifted geometric mean; without routes it is penalised."),
    "proved": Measure("proved", _share, max, r"Share of the runs that proved their routes optimal [\%].", 0.0),
    "solved": Measure("solved", _share, None, r"Share of the runs that found routes [\%].", 1.0),
}
"""Name of a table → what it tells."""
PACKAGES = r"\usepackage{booktabs,etoolbox,siunitx}\robustify\bfseries\sisetup{detect-weight=true,mode=text}"
"""What the preamble of a document needs that shows the tables."""


def size_tables(runs: pd.DataFrame) -> dict[str, tuple[str, str]]:
    """Return name → (LaTeX of the table, caption) of `runs` (`reports.stores.COLUMNS`)."""
    sized = banded(runs)
    found = scores(sized, ["n_depots", "n_tasks"])
    held = sized.groupby(["n_depots", "n_tasks"], observed=True)["digest"].nunique()
    made = {}
    for name, measure in MEASURES.items():
        values = found[measure.key]
        if values.notna().any() and not (values == measure.everywhere).all():
            made[name] = _tabular(found, held, measure), measure.caption
    return made


def _tabular(found: pd.DataFrame, held: pd.Series, measure: Measure) -> str:
    sizes = list(found.index.get_level_values("n_tasks").unique().sort_values())
    methods = list(found.groupby("method")["gap_found"].mean().sort_values(kind="stable").index)
    fleets = list(found.index.get_level_values("n_depots").unique().sort_values())
    cells = {(m, n): _cells(found.loc[(m, n)], int(held[m, n]), measure) for m, n in held.index}
    lines = []
    for m in fleets:
        if len(fleets) > 1:
            lines += [r"\addlinespace", rf"\multicolumn{{{len(sizes) + 1}}}{{l}}{{$m = {m}$}} \\"]
        for method in methods:
            row = [cells.get((m, n), {}).get(method, "{--}") for n in sizes]
            if any(cell != "{--}" for cell in row):
                lines.append(" & ".join([tex(str(method)), *row]) + r" \\")
    formats = "".join(_column([by.get(method, "") for by in _of(cells, n) for method in methods]) for n in sizes)
    heads = " & ".join(f"{{{tex(str(n))}}}" for n in sizes)
    return "\n".join(
        [
            f"% needs {PACKAGES}",
            rf"\begin{{tabular}}{{l{formats}}}",
            r"\toprule",
            rf"& \multicolumn{{{len(sizes)}}}{{c}}{{tasks $n$}} \\",
            rf"\cmidrule(lr){{2-{len(sizes) + 1}}}",
            rf"Method & {heads} \\",
            r"\midrule",
            *lines,
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def _of(cells: dict[tuple[Any, Any], dict[str, str]], size: Any) -> list[dict[str, str]]:
    return [by for (_, n), by in cells.items() if n == size]


def _cells(of_size: pd.DataFrame, instances: int, measure: Measure) -> dict[str, str]:
    """Return the cell of each method of one size, the best in bold."""
    texts = {str(method): measure.write(value) for method, value in of_size[measure.key].items() if not _missing(value)}
    fair = of_size[(of_size["instances"] == instances) & (of_size["solved"] == 1)].index
    printed = {method: _printed(texts[method]) for method in fair if method in texts}
    several = measure.best is not None and len(set(printed.values())) > 1
    best = measure.best(list(printed.values())) if measure.best and several else None
    bold = {method for method, value in printed.items() if value == best}
    return {method: _cell(text, method in bold) for method, text in texts.items()}


def _printed(text: str) -> float:
    return float(text) if NUMBER.fullmatch(text) else 0.0  # less than can be printed


def _missing(value: float) -> bool:
    return numbers.missing(value) or abs(value) == float("inf")


def _cell(text: str, bold: bool) -> str:
    plain = text if NUMBER.fullmatch(text) else f"{{{text}}}"
    return rf"\bfseries {plain}" if bold else plain


def _column(cells: list[str]) -> str:
    """Return the type of a column that aligns its numbers at the decimal point."""
    found = [match[0] for cell in cells if (match := NUMBER.fullmatch(cell.removeprefix(r"\bfseries ")))]
    whole = max((len(number.partition(".")[0]) for number in found), default=1)
    digits = max((len(number.partition(".")[2]) for number in found), default=0)
    return f"S[table-format={whole}.{digits}]"
