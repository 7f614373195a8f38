"""Whatever comes through the pipe is a message of the schema, or there is a sentence on why it is none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from workbench.jobs.process.messages import (
    Claimed,
    Ended,
    Event,
    Result,
    UnreadableError,
    encoded,
    figure,
    read_message,
    read_product,
    text,
    written,
)

EVENT = '{"kind": "event", "claim": {"product": null, "bound": BOUND}}'
RESULT = (
    '{"kind": "result", "claim": {"status": "FEASIBLE", "stopped_by": "", "message": "", "tolerance": TOLERANCE, '
    '"statistics": STATISTICS}}'
)


def result(tolerance: str = "0", statistics: str = "{}") -> str:
    return RESULT.replace("TOLERANCE", tolerance).replace("STATISTICS", statistics)


@pytest.mark.parametrize(
    "line",
    [
        *(EVENT.replace("BOUND", bad) for bad in ("Infinity", "NaN", "1e400", "9" * 400, "9" * 5000, '"7"', "[]")),
        *(result(tolerance=bad) for bad in ("Infinity", "NaN", "-1", "null", "1e400")),
        *(result(statistics=bad) for bad in ('{"a": Infinity}', f'{{"a": {"9" * 400}}}', "[]", r'{"a": "\ud800"}')),
        result(statistics='{"a":' * 20 + "1" + "}" * 20),
        result(statistics='{"a":' * 100_000 + "1" + "}" * 100_000),
        result(statistics=f'{{"a": "{"y" * 3_000_000}"}}'),
        '{"kind": "event", "claim": {"product": ' + "[" * 100_000 + "]" * 100_000 + "}}",
        "[" * 60_000,
        "[]",
        "null",
        "",
        "rubbish",
        '{"kind": "event"}',
        '{"kind": "event", "claim": {}, "elapsed": -4747}',
        '{"kind": "result", "claim": {}}',
        '{"kind": "result", "claim": {}, "peak_memory": 1}',
        '{"kind": "banana"}',
        '{"kind": "error", "message": "\udcff"}',
    ],
    ids=lambda line: line[-20:],
)
def test_what_is_no_message(line):
    with pytest.raises(UnreadableError) as refused:
        read_message(line.encode("utf-8", "surrogateescape"))
    assert len(str(refused.value)) < 400
    assert str(refused.value).isprintable()


@pytest.mark.parametrize("product", ["[[Infinity]]", "[[1e400]]", "[[1.5]]", '["a"]', "[" * 60_000, "{}", r'"\ud800"'])
def test_what_is_no_product(product):
    with pytest.raises(UnreadableError):
        read_product(encoded_raw(product), list[list[int]])


def encoded_raw(text_of: str):
    import msgspec

    return msgspec.Raw(text_of.encode())


def test_what_is_said_is_heard():
    told = Ended(encoded([np.arange(2), (2,)]), 3.5, None, status="OPTIMAL", stopped_by="proof", message="é",
                 tolerance=0.5, statistics={"moves": {"swap": [1, 2]}})  # fmt: skip
    line = written(Result(told))
    assert line.endswith(b"\n")
    heard = read_message(line[:-1])
    assert isinstance(heard, Result)
    assert read_product(heard.claim.product, list[list[int]]) == [[0, 1], [2]]
    assert (heard.claim.objective, heard.claim.tolerance, heard.claim.message) == (3.5, 0.5, "é")
    assert heard.claim.statistics == {"moves": {"swap": [1, 2]}}
    nothing = read_message(written(Event(Claimed(bound=1.0)))[:-1])
    assert isinstance(nothing, Event)
    assert read_product(nothing.claim.product, list[list[int]]) is None


def test_figures_are_spelled_out():
    told = {
        "inf": np.float64(math.inf),
        "grid": np.array([[1, 2]]),
        "one": np.int64(1),
        3: {1, 2},
        "n": None,
    }
    assert figure(told) == {"inf": "inf", "grid": [[1, 2]], "one": 1, "3": "{1, 2}", "n": None}
    assert figure([[[[1]]]]) == [[["[1]"]]]


def test_text_can_be_written_into_any_file():
    assert text(OSError("\udcff")) == r"\udcff"
    assert len(text("x" * 10**6)) == 2000
