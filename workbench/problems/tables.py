"""The study files of each problem as they are declared: their items, and their methods."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, field

from instances.declared.types import (
    FileName,
    NotNegative,
    Pair,
    Positive,
    Table,
    Text,
    Whole,
    about,
)
from workbench.jobs.study_table import (
    Counts,
    FamilyTable,
    Iterations,
    MethodTable,
    Seeds,
    SolverTable,
    StudyTable,
    Texts,
    Threads,
)
from workbench.map_keys import MAXIMISED, Criterion, PriorSd, Weights

Amount = Whole | NotNegative
"""A whole number stays one: it enters the digest of a problem as it is written."""
AMOUNT = "a number of at least 0"
FILES = "a file, folder or pattern, or a list of them"
Amounts = Positive | list[Positive]
Cells = Annotated[int, Meta(ge=4, le=1000)]


class RoutingTable(StudyTable, frozen=True, kw_only=True):
    """A study of routing: instances from files and families, and solvers."""

    problem: Annotated[Literal["routing"], about("what is studied", example="routing")] = "routing"
    threads: Threads = None
    iterations: Iterations = None
    files: Annotated[
        FileName | list[FileName],
        about("instances, relative to the study", example=["sets/*.json"], words=FILES),
    ] = field(default_factory=list)
    families: Annotated[
        list[FamilyTable],
        about("instances that are generated", example=[{"family": "uniform", "tasks": [10, 20], "depots": 3}]),
    ] = field(default_factory=list)
    solvers: Annotated[list[SolverTable], about("who solves them, at least one", example=[{"name": "greedy"}])] = field(
        default_factory=list
    )


class PlacementTable(StudyTable, frozen=True, kw_only=True):
    """A study of placement: regions with numbers of tasks, a setting, and methods."""

    problem: Annotated[Literal["placement"], about("what is studied", example="placement")] = "placement"
    regions: Annotated[
        Texts, about("files relative to the study, or square, the paper's of 20 km", example=["square", "a.geojson"])
    ] = field(default_factory=lambda: ["square"])
    tasks: Annotated[Counts, about("number of tasks n", example=[10, 20, 40])] = field(default_factory=lambda: [40])
    tests: Annotated[
        Text | None, about("test points: cells such as 20x20 unless given, or a .csv of x, y, weight", example="20x20")
    ] = None
    signal_sd: Annotated[Amount | None, about("σ_f of the kernel, 30 unless given", example=30.0, words=AMOUNT)] = None
    length_scale: Annotated[
        Amount | Text | None,
        about(
            "of the kernel, 4000 m unless given", "m", example=4000.0, words="a number of at least 0, or a text lx,ly"
        ),
    ] = None
    noise_sd: Annotated[
        Amount | None, about("σ_n of a reading at a task, 1 unless given", example=1.0, words=AMOUNT)
    ] = None
    test_noise_sd: Annotated[
        Amount | None, about("of a reading at a test point, noise_sd unless given", example=1.0, words=AMOUNT)
    ] = None
    criterion: Annotated[Criterion | None, about(f"{MAXIMISED}; b unless given", example="j")] = None
    weights: Weights = None
    prior_sd: PriorSd = None
    methods: Annotated[list[MethodTable], about("who places them, at least one", example=[{"name": "nlp"}])] = field(
        default_factory=list
    )


class MovingCostTable(StudyTable, frozen=True, kw_only=True):
    """A study of moving costs: scenarios from files and families, and methods."""

    problem: Annotated[Literal["moving-cost"], about("what is studied", example="moving-cost")] = "moving-cost"
    scenarios: Annotated[
        FileName | list[FileName], about("relative to the study", example=["survey.toml"], words="a file, or a list")
    ] = field(default_factory=list)
    families: Annotated[
        list[FamilyTable],
        about("scenarios that are generated", example=[{"family": "wind-vortices", "tasks": 12, "depots": 3}]),
    ] = field(default_factory=list)
    starts: Annotated[Counts, about("only the first so many nodes, all unless given", example=[10, 20])] = field(
        default_factory=list
    )
    methods: Annotated[list[MethodTable], about("who plans them, at least one", example=[{"name": "refined"}])] = field(
        default_factory=list
    )


class FieldTable(Table, frozen=True, kw_only=True):
    """A field that is measured: drawn, computed from a transmitter, or read; each seed is a field and its noise."""

    kind: Annotated[
        Literal["gp", "radio", "file"],
        about("gp: a draw of a Gaussian process; radio: as in missions; file: a raster", example="gp"),
    ]
    name: Annotated[Text | None, about("of the field, what makes it unless given", example="hills")] = None
    seeds: Annotated[
        Seeds,
        about("of field and noise: so many, or those listed", example=8, words="how many, or a list of whole numbers"),
    ] = 1
    kernel: Annotated[
        Literal["se", "matern52", "matern32", "matern12"], about("covariance of a draw, from smooth to rough")
    ] = "se"
    signal_sd: Annotated[Positive, about("σ_f of a draw, in the field's unit")] = 30.0
    length_scale: Annotated[Positive, about("of a draw", "m")] = 4000.0
    model: Annotated[
        Literal["diffraction", "free-space", "itm"], about("propagation of radio: diffraction, free-space or itm")
    ] = "diffraction"
    shadowing_sd: Annotated[NotNegative, about("of radio: shadowing, drawn at random", "dB")] = 4.0
    decorrelation: Annotated[Positive, about("of radio: where the shadowing's correlation has fallen to 1/e", "m")] = (
        4000.0
    )
    relief: Annotated[NotNegative, about("of radio: height of the synthetic mountains below", "m")] = 2000.0
    altitude: Annotated[Positive, about("of radio: flying altitude above mean sea level", "m")] = 3000.0
    file: Annotated[
        FileName | None, about("raster relative to the study: GeoTIFF, NetCDF or CSV", example="dem.tif")
    ] = None
    unit: Annotated[Text | None, about("unit of a file's values, what the file says unless given", example="m")] = None


class SurveyTable(StudyTable, frozen=True, kw_only=True):
    """A study of surveys: fields, endurances and what is believed before take-off, and plans."""

    problem: Annotated[Literal["survey"], about("what is studied", example="survey")] = "survey"
    fields: Annotated[
        list[FieldTable], about("what is measured, at least one", example=[{"kind": "gp", "seeds": 8}])
    ] = field(default_factory=list)
    region: Annotated[
        Text,
        about("a region's file relative to the study, or square, the paper's of 20 km", example="a.geojson"),
    ] = "square"
    scenario: Annotated[
        FileName | None,
        about("file that says region, zones, wind, depots and speed", example="scenario.toml"),
    ] = None
    depots: Annotated[
        list[Pair], about("where a UAV starts and ends, in the region", "m", words="a list of points [x, y]")
    ] = field(default_factory=lambda: [(10000.0, 19000.0), (1000.0, 1000.0), (19000.0, 1000.0)])
    endurance: Annotated[Amounts, about("longest flight of a UAV, or several to try", "s", example=[300.0, 492.0])] = (
        492.0
    )
    speed: Annotated[Positive, about("flying speed", "m/s")] = 100.0
    period: Annotated[Positive, about("time between two measurements of a UAV", "s")] = 10.0
    noise_sd: Annotated[Positive, about("σ_n of a measurement, in the field's unit")] = 1.0
    signal_sd: Annotated[Positive, about("σ_f that plans believe, in the field's unit")] = 30.0
    length_scale: Annotated[Positive, about("length scale that plans believe", "m")] = 4000.0
    cells: Annotated[Cells, about("cells of the judged map along the region's longer side")] = 50
    methods: Annotated[list[MethodTable], about("who plans them, at least one", example=[{"name": "workbench"}])] = (
        field(default_factory=list)
    )
