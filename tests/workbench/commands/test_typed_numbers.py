"""Every number on the command line: what cannot be one is refused at once, in one sentence that names the flag."""

from __future__ import annotations

import errno
import os

import pytest

from workbench.commands import solve

DIGITS = "9" * 5000
NO_NUMBER = ["", "x", "nan", "inf", "-inf", "-1", "1e308", DIGITS]
WHOLE = [*NO_NUMBER, "99999999999999999999", "1.5", "1e-320"]
POSITIVE = [*NO_NUMBER, "0", "1e-320"]
FLAGS = {
    "solve i.json": {"--seed": WHOLE, "--threads": [*WHOLE, "0", "1000000000"], "--iterations": WHOLE},
    "bound i.json": {"--seed": WHOLE, "--time-limit": [*POSITIVE, "99999999999999999999"]},
    "compare --dry-run": {"--seeds": [*WHOLE, "0", "1000000000"], "--threads": [*WHOLE, "0"], "--jobs": [*WHOLE, "0"]},
    "place": {"--tasks": [*WHOLE, "0"], "--seed": WHOLE, "--signal-sd": POSITIVE, "--noise-sd": POSITIVE},
    "place --method greedy": {"--test-noise-sd": POSITIVE, "--sd-limit": POSITIVE, "--max-sd": POSITIVE},
    "place --method grid": {"--study": [*WHOLE, "²", "n=1..99999999999999999999", "1..9:0"]},
    "place --tests 4x4": {"--length-scale": POSITIVE, "--tests": [*WHOLE, f"{DIGITS}x2", "0x4", "²x2"]},
    "generate uniform": {
        "--tasks": [*WHOLE, "0"],
        "--depots": [*WHOLE, "0"],
        "--count": [*WHOLE, "0"],
        "--seed": WHOLE,
    },
    "compare quick --dry-run": {"--shard": [*WHOLE, "0/3", "²/3", f"1/{DIGITS}"], "--retry": ["x", ","]},
}
CASES = [(at, flag, value) for at, flags in FLAGS.items() for flag in flags for value in dict.fromkeys(flags[flag])]
CASES += [("solve i.json", "--time-limit", value) for value in [*POSITIVE, "99999999999999999999"]]


def refused(told: tuple[int, str, str], *words: str) -> None:
    code, out, err = told
    assert (code, out) == (2, "")
    (sentence,) = err.splitlines()
    assert sentence.startswith("workbench: ")
    assert len(sentence) < 400
    for word in words:
        assert word in sentence


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(("words", "flag", "value"), CASES, ids=lambda text: text[:30])
def test_what_is_no_number_is_one_sentence(cli, words, flag, value):
    named = {"--length-scale": "length"}.get(flag, flag)
    refused(cli(*words.split(), flag, value), named)


@pytest.mark.parametrize(
    "pair",
    ["population=1e999", "population=99999999999999999999", f"population={DIGITS}", "elite=NaN", "elite=-Infinity",
     "elite=1e200", "elite=[[[", f"elite={'[' * 100_000}", "population={}", "population=", "=3", "border=null"],
    ids=lambda text: text[:30],
)  # fmt: skip
def test_options_of_a_method(cli, instance_file, pair):
    refused(cli("solve", instance_file, "--solver", "ga", "--option", pair))
    refused(cli("generate", "clustered", "--set", pair.replace("population", "clusters").replace("elite", "airspeed")))


@pytest.mark.parametrize("given", ["\udcff", "a\0b"], ids=["bytes", "zero"])
def test_what_is_no_text_is_refused_for_all_commands(cli, given):
    for words in (
        ["solve"],
        ["report", "--csv"],
        ["check"],
        ["status"],
        ["mission", "--out"],
        ["compare", "--solvers"],
    ):
        refused(cli(*words, given), "is not UTF-8 text")


@pytest.mark.parametrize(
    "words", [["solve"], ["check"], ["status"], ["report"], ["convert", "a.json"], ["compare", "quick", "--out"]]
)
def test_a_name_longer_than_the_system_allows(cli, words):
    code, _, err = cli(*words, "x" * 5000)
    assert code == 2
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "code", "word"),
    [
        (MemoryError(), 1, "needs more memory"),
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "/tmp"), 2, "No space left"),
    ],
)
def test_what_the_machine_refuses_is_a_sentence(cli, monkeypatch, error, code, word):
    def callback(**given):
        raise error

    monkeypatch.setattr(solve.command, "callback", callback)
    told = cli("solve", "i.json")
    assert told[0] == code
    assert word in told[2]
    assert told[2].count("\n") == 1


@pytest.mark.parametrize("error", [RecursionError(), OverflowError(), KeyError("x"), OSError(errno.EINVAL, "no")])
def test_a_fault_of_ours_keeps_its_traceback(cli, monkeypatch, error):
    def callback(**given):
        raise error

    monkeypatch.setattr(solve.command, "callback", callback)
    with pytest.raises(type(error)):
        cli("solve", "i.json")
