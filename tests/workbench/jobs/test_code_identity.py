"""A number knows the code that made it: edited kernels take effect, and what other code made is run again."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from instances import code, kernels

HERE = Path(__file__).parents[1]
KERNEL = "from instances.kernels import njit\n\n@njit(cache=True)\ndef inner(x):\n    return x + STEP\n"


@pytest.fixture
def checkout(tmp_path, monkeypatch) -> Path:
    """A copy of the four packages, to be edited."""
    folder = tmp_path / "checkout"
    for package in code.PACKAGES:
        shutil.copytree(code.ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), str(HERE)]))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "machine-code"))
    monkeypatch.chdir(tmp_path)
    return folder


def python(program: str, *args: str) -> str:
    """Return what `program` prints in a process of its own, which finds the copy first."""
    return subprocess.run([sys.executable, "-c", program, *args], capture_output=True, text=True, check=True).stdout


def workbench(*args: str) -> str:
    return python("from workbench.cli import main; main()", *args)


def test_a_changed_constant_in_an_imported_kernel_takes_effect(checkout):
    inner = checkout / "formulations" / "inner.py"
    (checkout / "formulations" / "outer.py").write_text(
        "from formulations.inner import inner\nfrom instances.kernels import njit\n\n"
        "@njit(cache=True)\ndef outer(x):\n    return 10 * inner(x)\n"
    )
    for step in (1, 2, 1):
        inner.write_text(KERNEL.replace("STEP", str(step)))
        os.utime(inner, (step, step))  # Python takes files of one size and one second for the same
        assert python("from formulations.outer import outer; print(outer(1))").strip() == str(10 * (1 + step))
    kept = list((checkout.parent / "machine-code").glob("kernels-of-*/*/formulations/outer.*.nbc"))
    assert len(kept) == 2  # the third time is the first again


def test_an_edit_that_a_kernel_cannot_see_compiles_nothing_again(checkout):
    (checkout / "formulations" / "inner.py").write_text(KERNEL.replace("STEP", "1"))
    program = "from formulations.inner import inner; inner(1)"
    python(program)
    kept = {path: path.stat().st_mtime_ns for path in checkout.parent.glob("machine-code/**/inner.*")}
    (checkout / "formulations" / "routing" / "greedy.py").write_text("# nothing of it is left\n")
    python(program)
    assert {path: path.stat().st_mtime_ns for path in checkout.parent.glob("machine-code/**/inner.*")} == kept


def test_all_that_a_kernel_imports_is_seen():
    program = (
        "import sys, pathlib, formulations.routing.search.annealing as a, instances.code as c\n"
        "def name(module): return pathlib.Path(module.__file__).relative_to(c.ROOT).as_posix()\n"
        "files = {name(m) for n, m in sys.modules.items() if n.split('.')[0] in c.KERNEL_PACKAGES}\n"
        "print(sorted(files - c.closure(name(a)) - {'formulations/__init__.py'}))\n"
    )
    assert python(program).strip() == "[]"


def test_another_checkout_of_the_same_sources_compiles_nothing_again(checkout, monkeypatch):
    (checkout / "formulations" / "inner.py").write_text(KERNEL.replace("STEP", "1"))
    program = "from formulations.inner import inner; inner(1)"
    python(program)
    kept = {path: path.stat().st_mtime_ns for path in checkout.parent.glob("machine-code/**/inner.*")}
    assert len(kept) == 2  # the index and the code
    other = checkout.rename(checkout.with_name("other"))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(other), str(HERE)]))
    python(program)
    assert {path: path.stat().st_mtime_ns for path in other.parent.glob("machine-code/**/inner.*")} == kept


def test_compare_runs_again_exactly_what_other_code_made(checkout, instance_folder):
    study = '[[solvers]]\nname = "misbehaving:Honest"\n'
    Path("one.toml").write_text('files = ["given/r4-2-0.json"]\ntime_limit = 5\n' + study)
    Path("both.toml").write_text('files = ["given/r4-2-[01].json"]\ntime_limit = 5\n' + study)
    workbench("compare", "one.toml", "--out", "runs", "--no-report")
    greedy = checkout / "formulations" / "routing" / "greedy.py"
    greedy.write_text(greedy.read_text() + "\n# edited\n")
    workbench("compare", "both.toml", "--out", "runs", "--no-report")
    assert json.loads(workbench("status", "runs", "--json"))["stale"] == 1
    before = {path: path.stat().st_mtime_ns for path in Path("runs").glob("r4*/*-s*-t*.json")}
    workbench("compare", "both.toml", "--out", "runs", "--no-report", "--retry", "stale")
    again = {path.parent.name[:6] for path, then in before.items() if path.stat().st_mtime_ns != then}
    assert again == {"r4-2-0"}
    assert json.loads(workbench("status", "runs", "--json"))["stale"] == 0


def test_the_digest_is_of_the_sources_and_of_nothing_else(checkout):
    program = "from instances.code import code_digest; print(code_digest())"
    first = python(program)
    (checkout / "reports" / "notes.txt").write_text("no source")
    assert python(program) == first
    (checkout / "reports" / "more.py").write_text("")
    assert python(program) != first


def test_a_run_in_a_checkout_names_its_revision(checkout):
    assert python("from instances.code import revision; print(repr(revision()))").strip() == "''"
    for words in (
        ["init", "-q"],
        ["add", "."],
        ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "first"],
    ):
        subprocess.run(["git", "-C", str(checkout), *words], check=True)
    clean = python("from instances.code import revision; print(revision())").strip()
    assert len(clean) == 12
    (checkout / "reports" / "__init__.py").write_text("")
    assert python("from instances.code import revision; print(revision())").strip() == f"{clean}-dirty"


def test_machine_code_nobody_used_for_a_week_is_removed(tmp_path):
    for name, age in (("kernels-old", 8), ("kernels-young", 6), ("other", 8)):
        (tmp_path / name).mkdir()
        then = time.time() - age * 24 * 3600
        os.utime(tmp_path / name, (then, then))
    kernels.remove_old(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kernels-young", "other"]
