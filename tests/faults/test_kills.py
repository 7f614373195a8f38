"""kill −9: nothing lost, repeated or left running. A hundred of them: ``python -m tests.faults.kills``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults.kills import KINDS, Kind, kill


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_kills(kind: Kind, tmp_path: Path) -> None:
    assert kill(3, 1, tmp_path, (kind,), each=3).wrong == []
