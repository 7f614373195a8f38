import contextlib
import gzip
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from formulations.moving_cost.families import generate
from instances import InputError, Instance
from instances.files import read_instance, write_instance
from instances.formats import native

finite = st.floats(0, 1e149, allow_nan=False)


@st.composite
def any_instance(draw):
    n, m = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    size = n + m
    cost = np.array(draw(st.lists(finite, min_size=size * size, max_size=size * size))).reshape(size, size)
    np.fill_diagonal(cost, 0)
    xy = draw(st.none() | st.lists(st.floats(-1e9, 1e9), min_size=2 * size, max_size=2 * size))
    name = draw(
        st.text(st.characters(blacklist_categories=["C", "Z"], blacklist_characters="/\\."), min_size=1, max_size=9)
    )
    json_value = (
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()
    )
    provenance = draw(st.dictionaries(st.text().filter(lambda key: key != "metric"), json_value, max_size=3))
    return Instance(name, cost, n, m, None if xy is None else np.reshape(xy, (size, 2)), provenance)


def same(a, b):
    assert (a.name, a.n_tasks, a.n_depots, a.digest) == (b.name, b.n_tasks, b.n_depots, b.digest)
    assert a.cost.tobytes() == b.cost.tobytes()
    assert (a.coordinates is None) == (b.coordinates is None)
    assert a.provenance == b.provenance


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(any_instance(), st.sampled_from([".json", ".json.gz"]))
def test_what_is_written_reads_back_to_the_last_bit(tmp_path, instance, ending):
    file = tmp_path / f"a{ending}"
    write_instance(instance, file)
    first = file.read_bytes()
    back = read_instance(file)
    same(instance, back)
    write_instance(back, file)
    assert file.read_bytes() == first
    assert [p.name for p in tmp_path.iterdir() if p.name.endswith(".part")] == []


def test_large_instances_are_stored_by_their_metric(tmp_path):
    instance = generate("uniform", 400, 3, seed=1, wind="rotation")
    write_instance(instance, tmp_path / "a.json")
    assert (tmp_path / "a.json").stat().st_size < 40_000
    assert read_instance(tmp_path / "a.json").cost.tobytes() == instance.cost.tobytes()


def test_a_metric_that_does_not_give_the_costs_is_not_used(tmp_path):
    instance = generate("uniform", 400, 3, seed=1)
    changed = Instance("x", instance.cost + instance.cost.T, 400, 3, instance.coordinates, instance.provenance)
    write_instance(changed, tmp_path / "a.json.gz")
    assert read_instance(tmp_path / "a.json.gz").cost.tobytes() == changed.cost.tobytes()


def test_cost_as_a_named_metric(tmp_path):
    file = tmp_path / "a.json"
    text = """{"schema": 1, "name": "a", "n_tasks": 2, "n_depots": 1, "coordinates": [[0, 0], [3, 4], [0, 1]],
              "cost": {"metric": "euclidean", "speed": 2}}"""
    file.write_text(text)
    assert read_instance(file).cost.tolist() == [
        [0, 2.5, 0.5],
        [2.5, 0, np.sqrt(18) / 2],
        [0.5, np.sqrt(18) / 2, 0],
    ]


DOCUMENT = {
    "schema": 1,
    "name": "a",
    "n_tasks": 2,
    "n_depots": 1,
    "cost": [[0, 1, 2], [3, 0, 4], [5, 6, 0]],
    "coordinates": [[0, 0], [1, 1], [2, 2]],
    "provenance": {},
}


def metric(**entries):
    return {"cost": entries}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"schema": 2}, "schema 2 is of a newer version; this one reads up to 1"),
        ({"schema": None}, "schema must be a whole number from 1 to 1, got None"),
        ({"schema": True}, "schema must be a whole number from 1 to 1, got True"),
        ({"schema": "1"}, "schema must be a whole number"),
        ({"n_tasks": 0}, "n_tasks must be a whole number of at least 1, got 0"),
        ({"n_depots": 0}, "n_depots must be a whole number of at least 1, got 0"),
        ({"n_depots": 1.0}, "n_depots must be a whole number of at least 1, got 1.0"),
        ({"n_tasks": "2"}, "n_tasks must be a whole number of at least 1"),
        ({"n_tasks": 10**30}, "0000000 tasks and 1 depots are more than the 20000 nodes an instance can have"),
        ({"cost": [[0, 1, 2], [3, 0, 4]]}, "cost has 2 rows, must have n_tasks . n_depots = 3"),
        ({"cost": [[0, 1, 2], [3, 0], [5, 6, 0]]}, r"cost\[1\] has 2 entries, must have 3"),
        ({"cost": [[0, 1, 2], [3, 0, "4"], [5, 6, 0]]}, r"cost\[1\]\[2\] must be a number \[s\], got '4'"),
        ({"cost": [[0, 1, 2], [3, 0, True], [5, 6, 0]]}, r"cost\[1\]\[2\] must be a number \[s\], got True"),
        ({"cost": [[0, 1, 2], [3, 0, float("nan")], [5, 6, 0]]}, "NaN is no JSON number"),
        ({"cost": [[0, 1, float("inf")], [3, 0, 4], [5, 6, 0]]}, "Infinity is no JSON number"),
        ({"cost": [[0, 1, 1e160], [3, 0, 4], [5, 6, 0]]}, r"cost\[0\]\[2\] is too large \(1e\+160\)"),
        ({"coordinates": [[0, 0], [1, 1e200], [2, 2]]}, r"coordinates\[1\] is more than 1e\+15 m away"),
        ({"cost": [[0, 1, 2], [3, 0, 4], [5, -6, 0]]}, r"cost\[2\]\[1\] is negative"),
        ({"cost": [[0, 1, 2], [3, 0, 4], [5, 10**400, 0]]}, r"cost\[2\]\[1\] must be a number \[s\], got 1000"),
        ({"cost": 5}, "cost must be a list of rows, each of .*, got 5"),
        ({"coordinates": [[0, 0], [1, 1]]}, "coordinates has 2 rows"),
        ({"coordinates": [[0, 0], [1, 1], [1]]}, r"coordinates\[2\] must be two numbers \[m\], got \[1\]"),
        ({"name": ""}, "name must be a non-empty text"),
        ({"provenance": []}, r"provenance must be an object, got \[\]"),
        ({"coordinate": 1}, "unknown key 'coordinate'; did you mean 'coordinates'"),
        (metric(metric="euclidian"), "cost.metric must be .*, got 'euclidian'; did you mean 'euclidean'"),
        (metric(metric=["euclidean"]), "cost.metric must be one of"),
        (metric(), "cost: the key 'metric' is missing: one of 'euclidean'"),
        (metric(metric="euclidean", sped=1), "unknown key 'sped' of metric = 'euclidean'; did you mean 'speed'"),
        (metric(metric="euclidean", speed=0), r"cost.speed must be a positive number \[m/s\], got 0"),
        (metric(metric="euclidean", rounding="up-ish"), "cost.rounding must be one of .*, got 'up-ish'"),
        ({**metric(metric="euclidean"), "coordinates": None}, "the metric 'euclidean' needs coordinates"),
        (metric(metric="wind"), "cost: the key 'airspeed' is missing"),
        (metric(metric="wind", airspeed=20, wind={"kind": "unifrom"}), "did you mean 'uniform'"),
        (metric(metric="wind", airspeed=20, wind={"kind": "uniform", "velocity": [20, 0]}), "below the ground speed"),
        (metric(metric="wind", airspeed=20, region=[[[0, 0], [1, 0], [1, 1]]]), r"cost\[0\]\[2\] is infinite"),
    ],
)
def test_one_sentence_names_file_field_and_value(tmp_path, changes, sentence):
    file = tmp_path / "bad.json"
    file.write_text(json.dumps({**DOCUMENT, **changes}))
    with pytest.raises(InputError, match=sentence) as caught:
        read_instance(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "number", ["-0", "-0.0", "1e22", "0.1", "123456789012345678901234567890", "5e-324", "9007199254740993"]
)
def test_dense_costs_are_read_to_the_same_bits_as_by_python(tmp_path, number):
    rows = [", ".join("0" if i == j else number for j in range(20)) for i in range(20)]
    costs = "[" + ", ".join(f"[{row}]" for row in rows) + "]"
    text = f'{{"schema": 1, "name": "a", "n_tasks": 18, "n_depots": 2, "cost": {costs}, "provenance": {{"a": 1}}}}'
    expected = np.array(json.loads(costs), dtype=float).tobytes()
    for rest, apart in (("", True), (" " * 100_000, False)):  # costs are most of the file, or not
        assert (native._costs_apart((text + rest).encode()) is not None) == apart
        (tmp_path / "a.json").write_text(text + rest)
        instance = read_instance(tmp_path / "a.json")
        assert instance.cost.tobytes() == expected
        assert instance.provenance == {"a": 1}


@pytest.mark.parametrize(
    ("costs", "words"),
    [
        ("[[0, 1, 2], [1, 0, 2], [1, 2]]", r"cost\[2\] has 2 entries, must have 3"),
        ("[[0, 1, 2], [1, 0, 2], [1, true, 0]]", r"cost\[2\]\[1\] must be a number \[s\], got True"),
        ("[[0, 1, 2], [1, 0, 2], [1, 1e400, 0]]", r"cost\[2\]\[1\] is infinite"),
        ("[[0, 1], [1, 0]]", "cost has 2 rows, must have n_tasks . n_depots = 3"),
        ('[[0, 1, 2], [1, 0, 2], [1, 2, 0]], "cost": 1', "'cost' is given twice"),
    ],
)
def test_dense_costs_that_are_wrong_are_told_as_others(tmp_path, costs, words):
    padded = costs.replace(", ", "," + " " * 100)
    (tmp_path / "a.json").write_text(f'{{"schema": 1, "name": "a", "n_tasks": 2, "n_depots": 1, "cost": {padded}}}')
    with pytest.raises(InputError, match=words):
        read_instance(tmp_path / "a.json")


@pytest.mark.parametrize("key", ["schema", "name", "n_tasks", "n_depots", "cost"])
def test_a_missing_key_is_named(tmp_path, key):
    file = tmp_path / "bad.json"
    file.write_text(json.dumps({k: v for k, v in DOCUMENT.items() if k != key}))
    with pytest.raises(InputError, match=key):
        read_instance(file)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.json", b"", "not valid JSON"),
        ("a.json", json.dumps(DOCUMENT).encode()[:60], "not valid JSON"),
        ("a.json", bytes(range(256)), "not UTF-8 text"),
        ("a.json", b'{"a": "\x00"}', "binary"),
        ("a.json", b'{"\xb2": 1, "cost": [[0, 1], [1, 0]]}', "not UTF-8 text"),
        ("a.json", b'{"cost": 1, "cost": [[0, 1], [1, 0]]}', "'cost' is given twice"),
        ("a.json", b'{"cost": [[0, 1], [true, 0]], "n": 1}', r"cost\[1\]\[0\] must be a number"),
        ("a.json", b"[1, 2]", "must hold a JSON object"),
        ("a.json", b"[" * 100_000, "not valid JSON"),
        ("a.json", b'{"schema": 1, "schema": 1}', "'schema' is given twice"),
        ("a.json", b'{"schema": ' + b"9" * 5000 + b"}", "not valid JSON"),
        ("a.json.gz", b"plain", "cannot be decompressed"),
        ("a.json.gz", gzip.compress(json.dumps(DOCUMENT).encode(), mtime=0)[:50], "cannot be decompressed"),
        ("a.json.gz", b"\x1f\x8b\x08\x00" + b"\xff" * 60, "cannot be decompressed"),
        ("a.jsn", b"{}", "'.jsn' is no ending of instance files; did you mean '.json'"),
        ("a", b"{}", "'' is no ending of instance files"),
    ],
)
def test_files_that_are_no_instance(tmp_path, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=sentence) as caught:
        read_instance(tmp_path / name)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_files_and_folders(tmp_path):
    with pytest.raises(InputError, match=r"nothing.json: cannot be read \(No such file"):
        read_instance(tmp_path / "nothing.json")
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(InputError, match=r"folder.json: cannot be read"):
        read_instance(tmp_path / "folder.json")


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.just(10**400) | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@settings(deadline=None, max_examples=300)
@given(st.sampled_from(sorted(DOCUMENT)), json_values)
def test_whatever_stands_in_a_field_is_read_or_refused_in_a_sentence(key, value):
    with contextlib.suppress(InputError):  # any other exception fails
        native.instance_of({**DOCUMENT, key: value})


@settings(deadline=None, max_examples=200)
@given(
    st.fixed_dictionaries(
        {"metric": st.sampled_from(["euclidean", "att", "wind"])},
        optional={
            "speed": json_values,
            "rounding": json_values,
            "airspeed": st.just(20) | json_values,
            "wind": json_values
            | st.fixed_dictionaries(
                {"kind": st.sampled_from(["uniform", "shear", "rotation", "sum"])},
                optional={"velocity": json_values, "rate": json_values, "centre": json_values, "parts": json_values},
            ),
            "region": json_values
            | st.lists(st.lists(st.lists(st.integers(-3, 3), max_size=3), max_size=5), max_size=2),
        },
    )
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_whatever_stands_in_a_metric_is_read_or_refused_in_a_sentence(cost):
    with contextlib.suppress(InputError):  # any other exception fails
        native.instance_of({**DOCUMENT, "cost": cost})


@settings(deadline=None, max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=40) | st.text(max_size=40).map(lambda t: t.encode("utf-8", "surrogatepass")))
def test_random_bytes_are_refused_in_a_sentence(tmp_path, content):
    for name in ("a.json", "a.json.gz", "a.tsp"):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError):
            read_instance(tmp_path / name)
