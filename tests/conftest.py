"""Laws are tried on the same drawn cases every time; `--hypothesis-profile=explore` draws fresh ones.

No case fails for taking long: a busy machine is no fault of the code.
"""

import pytest
from hypothesis import settings

settings.register_profile("explore", deadline=None)
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


@pytest.fixture
def without_figures(monkeypatch):
    """For tests of what else stands on a page: the figures are most of the seconds it takes."""
    monkeypatch.setattr("reports.pages.study.study_figures", lambda runs: [])


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch):
    """Nothing is wrapped or left out, whatever the terminal the suite is started from."""
    monkeypatch.delenv("COLUMNS", raising=False)
