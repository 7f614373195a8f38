"""What a refactoring must not change, recorded before it and compared after it, bit for bit.

    python tests/benchmarks/unchanged.py record FILE.json [--quick]
    python tests/benchmarks/unchanged.py compare FILE.json [--quick]

Makespans, routes, bounds and statistics of every solver on thirteen instances under an iteration limit (proving
methods: to their proof), generated families, a study's and a placement study's results.csv, `place`, `costs`, `bound`
and a small mission. Never what a clock or a machine decides: times, memory, environment, log. `compare` prints a line
for each difference and exits 1 where one was not expected; a key that is new is no difference, one that is gone is.
--quick takes a subset, also of a full recording; --only TEXT the cases whose name holds it
(`record --only` replaces these in the file).

It knows the code under test by its command line and files only (those `import workbench` finds: set PYTHONPATH), so
that one script serves the old code and the new. Instances are written once, into FILE.instances. Compiled kernels are
kept in a folder of their own for each state of the sources, since numba does not notice an edited kernel that is
imported; the first run after an edit therefore compiles for some minutes.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from unchanged_cases import Record, cases, digest, instances

EXPECTED = {"generate/corridor": "true costs in place of planned legs (issue 20)"}
"""Beginning of a case's name → why it may differ."""


def run(quick: bool, kept: Path, only: str) -> dict[str, Record]:
    """Return every case's record; instances are read from `kept`, made where they are missing."""
    kept.mkdir(parents=True, exist_ok=True)
    for name, instance in instances().items():
        if not (kept / f"{name}.json").exists():
            (kept / f"{name}.json").write_text(json.dumps({"name": name, **instance}))
    wanted = {name: case for name, case in cases(quick).items() if only in name}
    if not wanted:
        sys.exit(f"no case has '{only}' in its name")
    found = {}
    with tempfile.TemporaryDirectory() as room:
        shutil.copytree(kept, Path(room) / "instances")
        for number, (name, case) in enumerate(wanted.items()):
            folder = Path(room) / str(number)
            folder.mkdir()
            began = time.perf_counter()
            found[name] = json.loads(json.dumps(case(folder)))
            problem = found[name].get("error", "")
            print(f"{time.perf_counter() - began:6.1f} s  {name}  {problem}", file=sys.stderr, flush=True)
    return found


def differences(before: Any, after: Any, name: str) -> list[str]:
    """Return a line for each thing that changed or is gone."""
    if isinstance(before, dict) and isinstance(after, dict):
        return [
            line
            for key, value in before.items()
            for line in differences(value, after.get(key, "GONE"), f"{name} {key}")
        ]
    return [] if before == after else [f"{name}: {short(before)} -> {short(after)}"]


def short(value: Any) -> str:
    """Return a value for a line."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 200 else text[:190] + " ..."


def own_kernels() -> Path:
    """Make numba keep its code in a folder of this state of the sources, that of earlier states removed; say whose."""
    found = importlib.util.find_spec("workbench")
    if found is None or found.origin is None:
        sys.exit("no workbench to be imported: set PYTHONPATH to a checkout")
    root = Path(found.origin).parents[1]
    state = hashlib.sha256()
    for path in sorted(path for part in ("formulations", "instances") for path in (root / part).rglob("*.py")):
        state.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    mine = Path(tempfile.gettempdir()) / f"unchanged-kernels-{os.getuid()}" / digest(str(root)) / state.hexdigest()[:16]
    mine.mkdir(parents=True, exist_ok=True)
    for other in set(mine.parent.iterdir()) - {mine}:
        shutil.rmtree(other, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(mine)
    return root


def main() -> None:
    """Record or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("record", "compare"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    chosen = parser.parse_args()
    print(f"code under test: {own_kernels()}", file=sys.stderr)
    kept = chosen.file.with_suffix(".instances")
    if chosen.what == "record":
        found = run(chosen.quick, kept, chosen.only)
        if chosen.only and chosen.file.exists():
            found = json.loads(chosen.file.read_text()) | found
        chosen.file.write_text(json.dumps(found, indent=1, ensure_ascii=False, sort_keys=True))
        print(f"{len(found)} cases, {sum('error' in record for record in found.values())} of them failed")
        return
    before = json.loads(chosen.file.read_text())
    after = run(chosen.quick, kept, chosen.only)
    unexpected = 0
    for name, record in after.items():
        if name not in before:
            print(f"{name}: was not recorded")
            continue
        reason = next((why for start, why in EXPECTED.items() if name.startswith(start)), "")
        for line in differences(before[name], record, name):
            print(f"expected ({reason}): {line}" if reason else line)
            unexpected += not reason
    print(f"{len(after)} cases, {unexpected} unexpected differences")
    sys.exit(unexpected > 0)


if __name__ == "__main__":
    main()
