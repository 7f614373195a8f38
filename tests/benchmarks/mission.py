"""Mission: the whole chain of the paper's example from nothing, kernels compiled afresh. Run by hand:

python tests/benchmarks/mission.py [--quick]      (--quick: with the kernels as they are cached)
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MOST_SECONDS = 180.0
MOST_BYTES = 5e6


def run(out: Path, cache: Path | None) -> tuple[float, str]:
    """Return wall clock [s] of one `workbench mission` and what it told."""
    environment = dict(os.environ) | ({} if cache is None else {"NUMBA_CACHE_DIR": str(cache)})
    command = [sys.executable, "-c", "from workbench.cli import main; main()", "mission", "--out", str(out)]
    began = time.perf_counter()
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return time.perf_counter() - began, ended.stderr


def main() -> None:
    """Run the mission twice and print figures beside bars."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory() as folder:
        out, cache = Path(folder) / "out", None if quick else Path(folder) / "numba"
        first, told = run(out, cache)
        print(re.sub(r"^(?=.)", "    ", told, flags=re.M))
        print(
            f"{'ok  ' if first < MOST_SECONDS else 'MISS'} whole mission: {first:.0f} s (bar: < {MOST_SECONDS:.0f} s)"
        )
        again, told = run(out, cache)
        skipped = told.count("up to date")
        print(f"{'ok  ' if skipped == 8 else 'MISS'} again: {skipped} of 8 stages skipped, {again:.1f} s")
        size = (out / "report.html").stat().st_size
        print(f"{'ok  ' if size < MOST_BYTES else 'MISS'} page: {size / 1e6:.1f} MB (bar: < {MOST_BYTES / 1e6:.0f} MB)")


if __name__ == "__main__":
    main()
