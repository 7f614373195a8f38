"""Every reader, given what is no file, what opens to too much, and what is damaged: one sentence naming the file."""

import gzip
import json
import os
import resource
import socket
from pathlib import Path

import numpy as np
import pytest

from formulations.task_location.setting import region_of, rows_of_tests
from instances import InputError, Instance, documents
from instances.disk import read_bytes, read_json, read_text, read_toml, write_aside
from instances.environment.radio_files import read_field
from instances.environment.terrain import read_terrain
from instances.environment.wind_files import read_wind
from instances.files import read_instance, read_routes
from instances.formats.netcdf import read_grids
from instances.paths import read_paths
from instances.places import read_region
from instances.scenario import read_scenario
from instances.scenario_folder import kept_scenario
from reports.products import Products
from reports.record import read_run
from workbench.mission.file import read_mission
from workbench.mission.flight import kept_flights
from workbench.mission.place import kept_tasks
from workbench.mission.stamp import read_stamp

SMALL = Instance("x", np.zeros((2, 2)), 1, 1)


def named(read):
    """Return a reader whose sentences name the file, of one that leaves that to its caller."""

    def reader(path):
        try:
            return read(path)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None

    return reader


READERS = {
    "a.json": read_instance,
    "a.json.gz": read_instance,
    "a.atsp": read_instance,
    "a.mdm": read_instance,
    "a.sol": lambda path: read_routes(path, SMALL),
    "a.paths.json.gz": lambda path: read_paths(path, SMALL),
    "a.toml": read_scenario,
    "mission.toml": read_mission,
    "scenario.toml": lambda path: kept_scenario(path.parent),
    "a.geojson": read_region,
    "a.kml": read_region,
    "a.kmz": read_region,
    "a.gpkg": read_region,
    "a.shp": read_region,
    "a.zip": read_region,
    "b.geojson": region_of,
    "field.csv": read_field,
    "field.nc": read_field,
    "field.tif": read_field,
    "wind.nc": read_wind,
    "w_vel.asc": read_wind,
    "dem.asc": read_terrain,
    "dem.nc": read_terrain,
    "dem.tif": read_terrain,
    "grids.nc": read_grids,
    "tests.csv": rows_of_tests,
    "tasks.csv": lambda path: kept_tasks(path.parent),
    "ticks.csv": lambda path: Products({"map": path.parent}).table("map", path.name),
    "placement.json": lambda path: Products({"place": path.parent}).placement,
    "flights.json": lambda path: kept_flights(path.parent),
    "run.json": named(read_run),
}
JSON = [name for name in READERS if name.endswith((".json", ".geojson"))]
PACKED = [name for name in READERS if name.endswith(".gz")]
TOML = [name for name in READERS if name.endswith(".toml")]
TEXTS = [*JSON, *TOML, *(name for name in READERS if name.endswith((".csv", ".asc", ".sol", ".atsp", ".mdm")))]


def refused(path, words="."):
    with pytest.raises(InputError, match=words) as told:
        READERS[path.name](path)
    sentence = str(told.value)
    assert sentence.startswith(f"{path}: ")
    assert sentence.isprintable()
    assert len(sentence) <= len(str(path)) + 300
    return sentence


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_regular_file_is_not_opened(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    refused(path, "cannot be read")
    os.mkfifo(path)
    refused(path, "it is a pipe")
    path.unlink()
    path.symlink_to("/dev/zero")
    refused(path, "it is a device")
    path.unlink()
    path.mkdir()
    refused(path, "it is a folder")


@pytest.mark.parametrize("name", READERS)
def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(3_000_000_000)  # takes no room on the disk
    refused(path, "3,000,000,000 bytes, more than the 2,000,000,000 of WORKBENCH_LARGEST_FILE")
    path.write_bytes(b"{}" * 10)
    monkeypatch.setenv("WORKBENCH_LARGEST_FILE", "19")
    refused(path, "20 bytes, more than the 19")


def test_the_limit_must_be_a_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("a")
    monkeypatch.setenv("WORKBENCH_LARGEST_FILE", "2 GB")
    with pytest.raises(InputError, match="WORKBENCH_LARGEST_FILE: must be a whole number of bytes, got '2 GB'"):
        read_bytes(tmp_path / "a")


def test_a_socket_is_refused(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(tmp_path / "s"))
        with pytest.raises(InputError, match="s: cannot be read"):
            read_bytes(tmp_path / "s")
        with pytest.raises(InputError, match="s: cannot be written"):
            write_aside(tmp_path / "s", "x")


@pytest.mark.parametrize("content", [b"", b"\x89\x00\xff\xfe" * 20, b"\r1\r2\r", b"{]", b"a\xffb", b'"\\ud800"'])
@pytest.mark.parametrize("name", READERS)
def test_what_is_damaged_is_named(tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    if name == "tests.csv":
        assert not content or refused(path, "must have columns|not UTF-8|binary")
    else:
        refused(path)


NESTED = b"[" * 100_000


@pytest.mark.parametrize("content", [NESTED, NESTED + b"]" * 100_000, b"[" * 150 + b"]" * 150, b'{"a":' * 100_000])
@pytest.mark.parametrize("name", JSON)
def test_json_nested_without_end(tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    refused(path, "is not valid JSON .*nested")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"a": ' + b"9" * 5000 + b"}", "a whole number of too many digits"),
        (b'{"a": NaN}', "NaN is no JSON number"),
        (b"[-Infinity]", "-Infinity is no JSON number"),
        (b'{"a": 1, "a": 2}', "'a' is given twice"),
        (b'{"a": "\\ud800"}', "a lone surrogate"),
    ],
)
@pytest.mark.parametrize("name", JSON)
def test_json_that_python_alone_would_read(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    refused(path, words)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("name = " + "9" * 5000, "a whole number of too many digits"),
        ("name = " + "[" * 100_000, "nested too deeply"),
        ("name = " + "[" * 150 + "]" * 150, "nested more than 100 deep"),
        (".".join("a" * 20_000) + " = 1", "a key of more than 100 parts"),
        ("name = 1\rairspeed = 2", "is not valid TOML"),
    ],
)
@pytest.mark.parametrize("name", TOML)
def test_toml_that_takes_too_much(tmp_path: Path, name: str, content: str, words: str) -> None:
    path = tmp_path / name
    path.write_text(content, newline="")
    refused(path, words)


@pytest.mark.parametrize("name", PACKED)
def test_what_is_packed_is_opened_within_bounds(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / name
    path.write_bytes(gzip.compress(b" " * 1_000_000))
    monkeypatch.setattr(documents, "OPENS_AT_LEAST", 500_000)
    monkeypatch.setattr(documents, "CHUNK", 1000)
    refused(path, "cannot be decompressed .it opens to more than 500,000 bytes")
    path.write_bytes(b"\x1f\x8b\x08\x00\0\0\0\0\0\0" + b"\xff" * 60)
    refused(path, "cannot be decompressed")
    path.write_bytes(gzip.compress(NESTED))
    refused(path, "nested")


def test_a_bomb_takes_the_bound_and_not_what_it_opens_to() -> None:
    bomb = gzip.compress(bytes(1 << 20)) * 1000  # 1 GB in 1 MB
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InputError, match="opens to more than 6"):
        documents.decompressed(bomb)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 150_000  # KiB


def test_line_ends_of_every_kind(tmp_path: Path) -> None:
    for number, end in enumerate(("\n", "\r\n", "\r")):
        path = tmp_path / f"{number}.csv"
        path.write_bytes(end.join(["x,y", "1,2", "3,4", ""]).encode())
        assert rows_of_tests(path).tolist() == [[1, 2], [3, 4]]


@pytest.mark.parametrize("number", ["NaN", "1e308", "-1e308", "1e400", "2e9"])
def test_coordinates_of_a_region_are_places(tmp_path: Path, number: str) -> None:
    path = tmp_path / "a.geojson"
    path.write_text(f'{{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, {number}], [0, 0]]]}}')
    refused(path, "NaN is no JSON number|coordinates must be finite and at most 1e.09 m")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points": [[0, 0], [1e308, 1]]}, "points must be finite and at most"),
        ({"offsets": [0, -1, 2, 2, 2]}, "offsets must be a list of whole numbers of at least 0"),
        ({"offsets": [0, 2, 1, 2, 2]}, "offsets must rise"),
        ({"offsets": [0, 0, 10**30, 4, 4]}, "offsets must be a list"),
        ({"n_nodes": -2}, "n_nodes must be 2, got -2"),
        ({"n_nodes": None}, "n_nodes must be 2, got None"),
        ({"digest": 10**50}, "belongs to an instance of digest 1000"),
    ],
)
def test_numbers_in_a_file_of_paths(tmp_path: Path, change: dict[str, object], words: str) -> None:
    path = tmp_path / "a.paths.json.gz"
    table = {"schema": 1, "digest": SMALL.digest, "n_nodes": 2, "offsets": [0, 0, 2, 4, 4], "points": [[0, 0]] * 4}
    path.write_bytes(gzip.compress(json.dumps(table).encode()))
    assert read_paths(path, SMALL).n_nodes == 2
    path.write_bytes(gzip.compress(json.dumps({**table, **change}).encode()))
    refused(path, words)


def test_a_stamp_that_is_damaged_is_none(tmp_path: Path) -> None:
    for content in (b"", NESTED, b'{"stage": 1}', b'{"stage":"a","settings":"b","inputs":{},"products":[1]}'):
        (tmp_path / "stamp.json").write_bytes(content)
        assert read_stamp(tmp_path) is None


def test_the_readers_give_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"a": [1, 2.5, "\\ud83d\\ude00"]}')
    assert read_json(tmp_path / "a.json") == {"a": [1, 2.5, "\U0001f600"]}
    (tmp_path / "b.toml").write_text("a = {b = 1}\r\n")
    assert read_toml(tmp_path / "b.toml") == {"a": {"b": 1}}
    (tmp_path / "link").symlink_to("b.toml")
    assert read_text(tmp_path / "link") == "a = {b = 1}\r\n"
