"""Files of figures, for papers and other programs: pictures, and the values of each chart as CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from instances import InputError
from instances.disk import write_aside
from reports.csv_text import csv_text
from reports.figures.svg import Drawn, save_figure


def write_figures(figures: Iterable[Drawn], folder: Path | str, pictures: Sequence[str] = (".pdf", ".svg")) -> None:
    """Write KEY and each ending of `pictures` of each of `figures` into `folder`, and KEY.csv where it is a chart.

    Raises InputError where they cannot be written.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    for drawn in figures:
        for ending in pictures:
            path = Path(folder) / f"{drawn.name}{ending}"
            if ending == ".svg":
                write_aside(path, drawn.svg)
            else:
                save_figure(drawn.figure, path)
        if drawn.chart is not None:
            write_aside(Path(folder) / f"{drawn.name}.csv", csv_text(drawn.chart.frame()))
