"""UAVs are numbered from 0 wherever a person reads of them; a .sol, whose routes count from 1, says so."""

import re

from instances.files import read_instance, read_routes


def test_screen_and_files_number_uavs_alike(cli, tmp_path):
    assert cli("generate", "uniform", "--tasks", 4, "--uavs", 3)[0] == 0
    name = "uniform-n4-m3-s0.json"
    assert read_instance(tmp_path / name).n_depots == 3
    out = cli("solve", name, "--solver", "greedy", "--out", "a.sol")[1]
    flown = {int(k): tasks for k, tasks in re.findall(r"^UAV (\d+): .*, tasks (.*)$", out, re.MULTILINE)}
    assert list(flown) == [0, 1, 2]
    routes = read_routes(tmp_path / "a.sol", read_instance(tmp_path / name))
    assert [" ".join(map(str, route)) or "-" for route in routes] == list(flown.values())
    text = (tmp_path / "a.sol").read_text()
    assert "route #1 is that of UAV 0" in text
    assert re.findall(r"^Route #(\d):", text, re.MULTILINE) == ["1", "2", "3"]
    (tmp_path / "b.sol").write_text("Route #1: 0 1\nRoute #2: 2 3 9\n")
    assert "UAV 1 visits 9, which is not a task" in cli("check", name, "b.sol")[2]


def test_uavs_and_depots_are_one_number(cli):
    assert cli("generate", "uniform", "--uavs", 0)[2].startswith("workbench: --depots/--uavs: must be a whole number")
