"""Kept machine code of several processes meets in one: functions of the same name must stay apart."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SORTS = {
    "in_order": "copy = numbers.copy()\n    copy.sort()\n    return copy",
    "order": "return np.argsort(numbers)",
}
SCRIPT = """
import itertools, sys
import numba, numpy as np
from numba.core.bytecode import FunctionIdentity
if sys.argv[1] == "numba's own":
    FunctionIdentity._unique_ids = itertools.count(int(sys.argv[2]))
else:
    import instances.kernels
numbers = np.random.default_rng(0).random(200)
for name in sys.argv[3:]:
    found = getattr(__import__(name), name)(numbers)
    assert (np.sort(numbers) == (found if name == "in_order" else numbers[found])).all()
"""


@pytest.mark.parametrize(
    ("whose", "right"), [("ours", True), pytest.param("numba's own", False, marks=pytest.mark.slow)]
)
def test_kept_sorts_of_two_processes_are_not_mixed_up(tmp_path: Path, whose: str, right: bool) -> None:
    for name, body in SORTS.items():
        text = f"import numba, numpy as np\n\n@numba.njit(cache=True)\ndef {name}(numbers):\n    {body}\n"
        (tmp_path / f"{name}.py").write_text(text)

    def run(first: int, *names: str) -> bool:
        env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
        env["NUMBA_CACHE_DIR"] = str(tmp_path / "kept")
        done = subprocess.run([sys.executable, "-c", SCRIPT, whose, str(first), *names], env=env, capture_output=True)
        return done.returncode == 0

    assert run(1, "in_order")
    assert run(3, "order")  # with numba's own numbers what it calls is named as what the other has called
    assert run(100, "in_order", "order") == right
