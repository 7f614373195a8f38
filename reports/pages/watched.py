"""The page about a study as it runs: how far it has got, the table so far, the latest runs."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import pandas as pd
from markupsafe import Markup

from instances.errors import one_line
from reports import numbers
from reports.columns import SUMMARY, Column, shown
from reports.pages.blocks import Block, Facts, Lines, Note, Section, Table, cell, table_of
from reports.pages.page import Page, blocks_text, page_text

WATCHED = Page(
    "",
    "Looked at every two seconds. Runs are counted from their files; nothing is locked or written.",
    (),
    "This page is served by workbench watch on this machine alone and changes nothing.",
    "watched.js",
    {},
    live=True,
)
"""The page without what it shows."""
LATEST = [
    Column("instance", "Instance"),
    Column("label", "Method"),
    Column("seed", "Seed", "", "{}".format),
    Column("status", "Status"),
    Column("objective", "Objective", "", numbers.cost, "re-computed: of routes the longest tour [s]"),
    Column("elapsed", "Time", "s", numbers.seconds, "wall clock of the solve"),
]
MOST_DAMAGED = 20


@dataclass(frozen=True)
class Standing:
    """How far a study has got.

    facts : terms and their texts, for the head. counts : method → status → runs. latest : a row a run (LATEST).
    summary : of `metrics.summary`, or None where there is none (yet). damaged : a sentence each.
    """

    title: str
    facts: Sequence[tuple[str, str]]
    sentence: str
    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    latest: pd.DataFrame | None = None
    summary: pd.DataFrame | None = None
    damaged: Sequence[str] = ()


def standing_text(standing: Standing) -> Markup:
    """Return what changes of the page, as HTML."""
    blocks: list[Block] = [Facts(standing.facts, large=True), Note(standing.sentence)]
    if standing.damaged:
        title = numbers.counted(len(standing.damaged), "damaged file")
        blocks.append(Section(title, [Lines(standing.damaged[:MOST_DAMAGED])], "damaged", tone="alarm"))
    parts: list[Block] = [_counts(standing.counts)] if standing.counts else ["No run is stored yet."]
    if standing.summary is not None and len(standing.summary):
        found = standing.summary.reset_index()
        caption = "Over the runs stored so far: methods may have got further on some instances than others."
        parts.append(table_of(found, shown(SUMMARY, found), caption=caption, key="summary", methods=found["method"]))
    blocks.append(Section("So far", parts, "so-far"))
    if standing.latest is not None and len(standing.latest):
        blocks.append(Section("Latest runs", [table_of(standing.latest, LATEST, key="latest")], "latest"))
    return blocks_text(blocks)


def version_of(text: str) -> str:
    """Return the digest by which the page sees that there is something new."""
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()[:12]


def watched_page(standing: Standing) -> str:
    """Return the whole page as HTML; its script asks for ``data.json`` and shows its `html` where `version` is new."""
    text = standing_text(standing)
    lost = "No answer: workbench watch has ended, or its folder cannot be read. What stands here is old."
    live = Markup('<p id="lost" class="alarm" role="alert" hidden>{}</p><div id="live" data-version="{}">{}</div>')
    part = Section("Progress", [live.format(lost, version_of(text), text)], "progress")
    return page_text(replace(WATCHED, title=standing.title, blocks=[part]))


def _counts(counts: dict[str, dict[str, int]]) -> Table:
    """Return runs by method and status."""
    statuses = sorted({status for of in counts.values() for status in of})
    columns = [Column("label", "Method"), *(Column(status, one_line(status, 40), "", str) for status in statuses)]
    columns = [columns[0], *(column._replace(write=numbers.count) for column in columns[1:])]
    rows = [
        [cell(columns[0], label), *(cell(column, of.get(column.key, 0)) for column in columns[1:])]
        for label, of in sorted(counts.items())
    ]
    return Table(columns, rows, "Stored runs by how they ended.", "counts")
