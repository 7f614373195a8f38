"""Document: the files of a paper about a study: tables, figures, references, and a ``main.tex`` that shows them all."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import pandas as pd

from reports.figures import Drawn, study_figures
from reports.figures.svg import save_figure
from reports.foreign import foreign_notes
from reports.metrics import with_gaps
from reports.paper.size_tables import PACKAGES, size_tables
from reports.tex import tex

_ENTRY = re.compile(r"^@\w+\{([^,\s]+),.*?^\}$", re.M | re.S)


@dataclass(frozen=True)
class Cited:
    """A method of the study: its name, what it is in a line, and what to cite for it."""

    name: str
    about: str
    keys: Sequence[str]


def paper_files(title: str, runs: pd.DataFrame, claims: Sequence[str], methods: Sequence[Cited]) -> dict[str, bytes]:
    """Return the files of the paper by their names.

    runs : the frame `reports.stores.read_stores` returns, of routing; it may be empty. claims : values without routes.
    methods : all that the study ran, of whatever problem.
    """
    known = with_gaps(runs) if len(runs) else runs
    tables = size_tables(runs) if len(runs) else {}
    figures = study_figures(known) if len(runs) else []
    files = {f"tables/{name}.tex": text.encode() for name, (text, _) in tables.items()}
    files |= _drawn(figures)
    keys = list(dict.fromkeys(key for method in methods for key in method.keys))
    files["references.bib"] = "\n\n".join([*(references()[key] for key in keys), ""]).encode()
    captions = {name: caption for name, (_, caption) in tables.items()}
    notes = foreign_notes(runs, claims) if len(runs) else []
    files["main.tex"] = _main(title, captions, figures, methods, notes).encode()
    return files


@cache
def references() -> dict[str, str]:
    """Return every entry of the literature by its key."""
    text = resources.files("reports").joinpath("data", "references.bib").read_text(encoding="utf-8")
    return {entry[1]: entry[0] for entry in _ENTRY.finditer(text)}


def _drawn(figures: Iterable[Drawn]) -> dict[str, bytes]:
    """Return each figure as PDF."""
    files = {}
    with tempfile.TemporaryDirectory() as folder:
        for drawn in figures:
            path = Path(folder) / "figure.pdf"
            save_figure(drawn.figure, path)
            files[f"figures/{_file_name(drawn)}.pdf"] = path.read_bytes()
    return files


def _file_name(drawn: Drawn) -> str:
    return re.sub(r"[^A-Za-z0-9-]", "-", drawn.key)


def _main(
    title: str, tables: dict[str, str], figures: Sequence[Drawn], methods: Sequence[Cited], notes: Sequence[str]
) -> str:
    floats = [_float("table", rf"\caption{{{text}}}", rf"\input{{tables/{name}}}") for name, text in tables.items()]
    for drawn in figures:
        caption = rf"\caption{{\textbf{{{tex(drawn.title)}.}} {tex(drawn.caption)}}}"
        picture = rf"\includegraphics[width=\linewidth]{{figures/{_file_name(drawn)}}}"
        floats.append(_float("figure", picture, caption))
    listed = []
    for method in methods:
        cite = rf"~\cite{{{','.join(method.keys)}}}" if method.keys else ""
        listed.append(rf"\item \texttt{{{tex(method.name)}}}: {tex(method.about)}{cite}.")
    return "\n".join(
        [
            r"\documentclass{article}",
            r"\usepackage[T1]{fontenc}",
            r"\usepackage{graphicx,url}",
            r"\usepackage[margin=2.5cm]{geometry}",
            PACKAGES,
            r"\begin{document}",
            rf"\section*{{{tex(title)}}}",
            *(f"{tex(note)}\n" for note in notes),
            r"\begin{itemize}",
            *listed,
            r"\end{itemize}",
            *floats,
            r"\bibliographystyle{plain}",
            r"\bibliography{references}",
            r"\end{document}",
            "",
        ]
    )


def _float(kind: str, above: str, below: str) -> str:
    narrow = [r"\small\setlength{\tabcolsep}{4pt}"] if kind == "table" else []
    lines = [rf"\begin{{{kind}}}[htbp]", r"\centering", *narrow, above, below, rf"\end{{{kind}}}"]
    return "\n".join(["", *lines])
