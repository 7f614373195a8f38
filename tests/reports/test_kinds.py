"""What a stored run may hold: each value of its kind, else the file is refused in one short sentence."""

import json

import pytest

from instances import InputError
from reports.record import run_from

BASE = {
    "schema": 1, "instance": {"name": "i", "digest": "d"}, "solver": "s", "seed": 0, "time_limit": 1.0,
    "status": "FEASIBLE", "objective": 1.0, "bound": None,
}  # fmt: skip
PLACEMENT = BASE | {"problem": "placement", "certificate": 2.0}
MOVING = BASE | {"problem": "moving-cost"}
SURVEY = BASE | {"problem": "survey"}
DEEP = json.loads("[" * 80 + "]" * 80)

BAD = [
    (BASE, "problem", []), (BASE, "schema", 10**400), (BASE, "instance", "i"), (BASE, "instance", {"name": "i"}),
    (BASE, "instance", {"name": "i", "digest": "d", "n_tasks": 1.5}),
    (BASE, "instance", {"name": "i", "digest": "d", "n_tasks": 10**400}),
    (BASE, "instance", {"name": "i", "digest": "d", "family": 3}),
    (BASE, "instance", {"name": "i", "digest": "d", "best_known": -1e300}),
    (BASE, "seed", 10**400), (BASE, "seed", True), (BASE, "seed", None),
    (BASE, "time_limit", None), (BASE, "time_limit", 0), (BASE, "time_limit", 10**400), (BASE, "elapsed", -4747.0),
    (BASE, "peak_memory", -1), (BASE, "threads", "2"), (BASE, "objective", float("inf")), (BASE, "bound", 10**400),
    (BASE, "tolerance", float("nan")), (BASE, "label", 3), (BASE, "options", []), (BASE, "statistics", "x"),
    (BASE, "routes", [[10**400]]), (BASE, "routes", [1]), (BASE, "routes", [[0.5]]), (BASE, "routes", DEEP),
    (BASE, "tour_costs", ["a"]), (BASE, "trace", [[1, 2]]), (BASE, "trace", [[1, "2", None]]),
    (BASE, "trace", [[-1, 2, None]]), (BASE, "trace", [[1, float("inf"), None]]), (BASE, "trace", [[None, 1, 1]]),
    (BASE, "trace", {"a": 1}), (BASE, "trace", [[1, 10**400, None]]),
    (PLACEMENT, "certificate", None), (PLACEMENT, "points", [[1, 2, 3]]), (PLACEMENT, "points", [[1, None]]),
    (PLACEMENT, "points", [[1], [1, 2]]), (PLACEMENT, "points", [[]]), (PLACEMENT, "information", {"b": "x"}),
    (MOVING, "cost", [[1, 2]]), (MOVING, "cost", [[1, float("nan")], [1, 2]]), (MOVING, "cost", [["1"]]),
    (MOVING, "paths", {"offsets": [0.5], "points": []}), (MOVING, "paths", {"points": []}), (MOVING, "cost", DEEP),
    (SURVEY, "tours", [[1, 2]]), (SURVEY, "tours", [[[1, float("nan")]]]), (SURVEY, "samples", [[[1, 2, 3]]]),
    (SURVEY, "read", [[0, 1, 2.0]]), (SURVEY, "read", [[-1, 1, 2.0, 3.0]]), (SURVEY, "rmse", "x"),
    (SURVEY, "tours", DEEP),
]  # fmt: skip


@pytest.mark.parametrize(("base", "key", "value"), BAD)
def test_what_is_not_of_its_kind_is_refused(base, key, value):
    run_from(base)
    with pytest.raises(InputError) as told:
        run_from(base | {key: value})
    assert key in str(told.value)
    assert len(str(told.value)) < 300


def test_lines_are_printable_and_times_in_order():
    texts = {"label": "a\nb", "message": "\x1b[31m" + "x" * 5000}
    run = run_from(BASE | texts | {"trace": [[2, 1, None], [1, 2, None]], "log": "a\nb"})
    assert run.label == "a b"
    assert run.message.startswith("\\x1b[31mxx")
    assert len(run.message) <= 1010
    assert [time for time, _, _ in run.trace] == [1, 2]
    assert run.log == "a\nb"
    assert run.instance["n_tasks"] is None
