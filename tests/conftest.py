"""Laws are tried on the same drawn cases every time; `--hypothesis-profile=explore` draws fresh ones.

No case fails for taking long: a busy machine is no fault of the code.
"""

import os
import subprocess
import sys
import tempfile

import pytest
from hypothesis import settings

from workbench.threads import keep_to_one

# numba looks whether this is a terminal with colours at each overload that does not fit, of which it tries many
os.environ["NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING"] = "1"
keep_to_one()  # as the command line does: with BLAS on two threads two workers on two cores wait for each other

settings.register_profile("explore", deadline=None)
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


KERNELS = (
    ("memetic", "ruin-recreate", "fleets", "exact", "branch-and-price", "branch-and-cut", "states"),
    ("costs", "ga", "select", "map", "clocks"),
)
"""What two processes compile before the whole suite begins: two workers of it would each compile all of them.

In this order few kernels are compiled twice: what others need as well comes first in the one, last in the other.
"""


def pytest_configure(config):
    whole = config.args_source is config.ArgsSource.TESTPATHS and not config.option.collectonly
    if hasattr(config, "workerinput") or not whole:
        return
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):  # some hundred processes would each compile all they import
        folder = tempfile.TemporaryDirectory(prefix="byte-code-", ignore_cleanup_errors=True)
        os.environ["PYTHONPYCACHEPREFIX"] = folder.name
        config.add_cleanup(folder.cleanup)
    program = [sys.executable, "-c", "from workbench.cli import main; main()", "warmup"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    for process in [subprocess.Popen([*program, *names], **quiet) for names in KERNELS]:
        process.wait()


@pytest.fixture
def without_figures(monkeypatch):
    """For tests of what else stands on a page: the figures are most of the seconds it takes."""
    monkeypatch.setattr("reports.pages.study.study_figures", lambda runs: [])


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch):
    """Nothing is wrapped or left out, whatever the terminal the suite is started from."""
    monkeypatch.delenv("COLUMNS", raising=False)
