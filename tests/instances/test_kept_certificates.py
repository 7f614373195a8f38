"""Every certificate that comes along is one of its public instance and of the bound in the record book."""

from pathlib import Path

import pytest

import instances
from instances.best_known import best_known
from instances.certificate import SUFFIX, read_certificate, verify
from instances.files import read_instance

KEPT = sorted((Path(instances.__file__).parent / "data" / "certificates").glob(f"*{SUFFIX}"))
FOLDER = Path(__file__).resolve().parents[2] / ".." / "shared" / "benchmarks" / "single_mtsplib"
QUICK, QUICK_OVER_ARCS = 500, 1_000_000
"""Bytes of a certificate of one step, about, and of one over arcs of a second; larger ones are tried by hand."""


def slow(path: Path) -> bool:
    """Say whether a certificate takes long to check."""
    return path.stat().st_size >= (QUICK_OVER_ARCS if read_certificate(path).cuts else QUICK)


def test_there_are_some():
    assert KEPT


@pytest.mark.parametrize("path", KEPT, ids=lambda path: path.name.removesuffix(SUFFIX))
def test_it_claims_what_the_book_says(path):
    certificate = read_certificate(path)
    known = best_known(certificate.digest)
    assert known is not None
    assert known.bound is not None
    assert certificate.bound == pytest.approx(known.bound, rel=1e-6)


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=[pytest.mark.slow] if slow(path) else []) for path in KEPT],
    ids=lambda path: path.name.removesuffix(SUFFIX),
)
@pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no benchmark instances beside the repository ({FOLDER.name})")
def test_it_holds(path):
    instance = read_instance(FOLDER / f"{path.name.removesuffix(SUFFIX)}.mdm")
    assert verify(instance, read_certificate(path)).problems == ()
