"""Rooms: our packages `instances`, `formulations` and `reports`, found beside this one.

Python looks in a script's own folder first, where an `instances.py` of the user's would be taken for ours.
"""

from __future__ import annotations

import sys
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path

ROOMS = ("instances", "formulations", "reports")


def claim() -> None:
    """Import our rooms from where this package lies; ImportError where other modules already have their names."""
    home = Path(__file__).resolve().parent.parent
    for name in ROOMS:
        there = sys.modules.get(name)
        if there is not None:
            file = getattr(there, "__file__", None)
            if file is None or Path(file).resolve().parent.parent != home:
                raise ImportError(
                    f"the module '{name}' ({file}) is imported already and hides the workbench's package of that name: "
                    "import workbench before it, or give it another name"
                )
            continue
        spec = PathFinder.find_spec(name, [str(home)])
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
