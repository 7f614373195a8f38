"""Path polish on a mission's page: nothing where tours stayed, what was gained where they were moved."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from instances.environment.region import Region
from instances.errors import InputError
from reports.pages.polish import path_polish
from reports.products import Products

SAID = {
    "rms_sd_before": 4.0, "rms_sd_after": 3.0, "bound": 1.0, "samples_after": 9, "costs_before": [90.0],
    "costs_after": [99.0], "budgets": [100.0], "endurance_given": [True], "lengths_before": [900.0],
    "lengths_after": [990.0],
}  # fmt: skip
SCENARIO = SimpleNamespace(free=Region.rectangle(300, 300), no_fly=[], depots=np.array([[10.0, 10.0]]))


def test_what_was_gained_and_used_is_told(tmp_path: Path) -> None:
    (tmp_path / "polish.json").write_text(json.dumps(SAID))
    path = pd.DataFrame({"uav": 0, "x": [10, 200, 10], "y": [10, 200, 10], "task": [-1, 0, -1]})
    for name in ("polished.csv", "unpolished.csv"):
        path.to_csv(tmp_path / name, index=False)
    products = Products({"flight": tmp_path})
    products.__dict__.update(scenario=SCENARIO, unit="dBm")
    blocks, figures = path_polish(products, np.array([[200.0, 200.0]]))
    said = str(blocks[0])
    assert "from 4 to 3 dBm (-25%). No tours from these depots" in said
    assert "can leave less than 1 dBm" in said
    assert [cell.text for cell in blocks[1].rows[0]][-1] == "99.0"
    assert figures == blocks[2:]
    assert (products.flown_tasks == [[200.0, 200.0]]).all()


def test_where_nothing_was_polished_nothing_is_told(tmp_path: Path) -> None:
    assert path_polish(Products({"flight": tmp_path}), np.empty((0, 2))) == ([], [])


@pytest.mark.parametrize("wrong", [{"bound": "much"}, {"budgets": []}, {"rms_sd_before": 0.0}])
def test_a_damaged_polish_is_told(tmp_path: Path, wrong: dict) -> None:
    (tmp_path / "polish.json").write_text(json.dumps(SAID | wrong))
    with pytest.raises(InputError, match=r"polish\.json"):
        _ = Products({"flight": tmp_path}).polish
