"""The paper's whole chain, stage by stage: environment → place → costs → routes → flight → map → compare → report.

Every stage reads the products of those before it from their folders and writes its own folder, aside and renamed.
"""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType


class _Mission(ModuleType):
    """This package, called: importing it hides the façade's function of the same name from ``wb.mission``."""

    def __call__(self, file: Path | str = "paper", out: Path | str = "mission") -> Path:
        """Run a mission, as `workbench.facade.mission`."""
        from workbench.facade import mission

        return mission(file, out)


sys.modules[__name__].__class__ = _Mission
