"""Threads that read by one declaration for the first time, all at once, read it."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import sys, threading
import msgspec
from instances.declared.reading import read_declared

THREADS, KINDS = 4, 60
sys.setswitchinterval(1e-6)
barrier, read = threading.Barrier(THREADS), []
kinds = []
for i in range(KINDS):
    inner = [msgspec.defstruct(f"Inner{i}_{j}", [("x", int), ("y", float)]) for j in range(20)]
    kinds.append(msgspec.defstruct(f"Outer{i}", [(f"f{j}", each) for j, each in enumerate(inner)]))
given = {f"f{j}": {"x": j, "y": 0.5} for j in range(20)}
how = {"ours": read_declared, "msgspec": lambda kind, value: msgspec.convert(value, kind)}[sys.argv[1]]

def one():
    for kind in kinds:
        barrier.wait()
        read.append(how(kind, given).f7.x)

threads = [threading.Thread(target=one) for _ in range(THREADS)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert read == [7] * (THREADS * KINDS)
"""


def test_a_declaration_is_read_by_threads_at_once():
    """Without `prepared` the process is killed by a segmentation fault ("msgspec" for "ours": 12 of 12 runs)."""
    done = subprocess.run([sys.executable, "-c", SCRIPT, "ours"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
