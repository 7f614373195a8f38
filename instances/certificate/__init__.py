"""Certificates of lower bounds: what a proof by columns or arcs relied on, and a check that shares no code with it."""

from instances.certificate.checking import Verdict, verify
from instances.certificate.file import (
    SUFFIX,
    ArcPrices,
    Blossom,
    Certificate,
    Crowd,
    Cut,
    Node,
    Prices,
    Step,
    read_certificate,
    write_certificate,
)

__all__ = [
    "SUFFIX",
    "ArcPrices",
    "Blossom",
    "Certificate",
    "Crowd",
    "Cut",
    "Node",
    "Prices",
    "Step",
    "Verdict",
    "read_certificate",
    "verify",
    "write_certificate",
]
