"""`workbench costs`, and planned paths through `generate` and `check`."""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from instances.errors import InputError
from instances.files import read_instance
from instances.paths import paths_file, read_paths
from workbench.cli import commands

SCENARIO = """
ground_speed = 20.0
size = [10000, 10000]
no_fly = "zones.geojson"
depots = [[500, 500], [9500, 9000], [500, 500]]
tasks = [[2000, 8000], [8000, 2000], [7000, 7500]]
[wind]
kind = "sum"
parts = [
  {kind = "uniform", velocity = [-4, -4]},
  {kind = "vortices", centres = [[3000, 4000]], circulation = [3e4], core = [800]},
]
"""
ZONES = {"type": "Polygon", "coordinates": [[[4000, 4000], [6000, 4200], [5200, 6500], [4000, 4000]]]}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "s.toml").write_text(SCENARIO)
    (tmp_path / "zones.geojson").write_text(json.dumps(ZONES))
    return tmp_path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(commands, list(map(str, arguments)))


def test_costs_writes_an_instance_and_confirmed_paths(folder: Path) -> None:
    result = run("costs", folder / "s.toml", "--out", folder / "s.json", "--option", "samples=500")
    assert result.exit_code == 0, result.output
    for words in ("30 paths by refined", "all confirmed", "max |w|/v0", "rms curl", "beyond the potential part"):
        assert words in result.stdout
    assert "100%" in result.stderr
    instance = read_instance(folder / "s.json")
    assert (instance.n_tasks, instance.n_depots) == (3, 3)
    assert instance.cost[3, 5] == 0  # two UAVs at one depot
    paths = read_paths(paths_file(folder / "s.json"), instance)
    np.testing.assert_allclose(paths.along([3, 0, 2, 3])[[0, -1]], [[500, 500], [500, 500]])
    result = run("check", folder / "s.paths.json.gz")
    assert (result.exit_code, "30 paths of s: all right" in result.stdout) == (0, True)


def test_check_finds_a_path_that_was_tampered_with(folder: Path) -> None:
    run("costs", folder / "s.toml", "--out", folder / "s.json", "--method", "dijkstra", "--option", "samples=500")
    file = folder / "s.paths.json.gz"
    table = json.loads(gzip.decompress(file.read_bytes()))
    k = table["offsets"][4 * 6 + 2] + 1  # the second point of the path from depot 4 to task 2
    table["points"][k] = [5100.0, 5000.0]
    file.write_bytes(gzip.compress(json.dumps(table).encode()))
    result = run("check", file)
    assert result.exit_code == 1
    assert "The path from 4 to 2 runs" in result.stdout
    assert "The path from 4 to 2 costs" in result.stdout


def test_generate_plans_missions_in_wind(tmp_path: Path) -> None:
    result = run("generate", "wind-vortices", "--tasks", 4, "--depots", 2, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert run("check", next(tmp_path.glob("*.paths.json.gz"))).exit_code == 0
    assert len(list(tmp_path.glob("*.toml"))) == 1


def test_generate_plans_around_walls_and_solve_draws_along_the_paths(tmp_path: Path) -> None:
    out = run("generate", "corridor", "--tasks", 5, "--depots", 2, "--out", tmp_path).stdout
    assert run("check", next(tmp_path.glob("*.paths.json.gz"))).exit_code == 0
    instance = Path(out.strip())
    pictures = []
    for name in ("planned", "straight"):
        picture = tmp_path / f"{name}.svg"
        assert run("solve", instance, "--solver", "greedy", "--plot", picture).exit_code == 0
        pictures.append(picture.read_bytes())
        paths_file(instance).unlink(missing_ok=True)
    assert pictures[0] != pictures[1]


def test_generate_in_open_country_writes_the_instance_alone(tmp_path: Path) -> None:
    out = run("generate", "uniform", "--tasks", 5, "--depots", 2, "--set", "wind=rotation", "--out", tmp_path).stdout
    assert list(tmp_path.iterdir()) == [Path(out.strip())]


def test_costs_in_closed_form(folder: Path) -> None:
    calm = SCENARIO[: SCENARIO.index("[wind]")].replace('no_fly = "zones.geojson"\n', "")
    (folder / "s.toml").write_text(calm + '[wind]\nkind = "rotation"\nrate = 1e-4\ncentre = [5000, 5000]\n')
    for method in ("closed-form", "refined"):
        result = run("costs", folder / "s.toml", "--out", folder / f"{method}.json", "--method", method)
        assert result.exit_code == 0, result.output
        assert f"30 paths by {method}" in result.stdout
    exact, refined = (read_instance(folder / f"{method}.json").cost for method in ("closed-form", "refined"))
    np.testing.assert_allclose(refined, exact, rtol=1e-5)
    assert run("check", folder / "closed-form.paths.json.gz").exit_code == 0


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        (("velocity = [-4, -4]", "velocity = [-4]"), (), "velocity"),
        (("circulation = [3e4]", "circulation = [5e5]"), (), r"wind: at \(\d+, \d+\) m it blows with \d+(\.\d+)? m/s"),
        (("[2000, 8000]", "[5000, 5000]"), (), "no-fly zone"),
        (("[2000, 8000]", "[2000, 18000]"), (), "outside the region"),
        (("", ""), ("--method", "fmtstar"), "did you mean 'fmt-star'"),
        (("", ""), ("--option", "sample=3"), "did you mean 'samples'"),
    ],
)
def test_bad_scenarios_are_named(folder: Path, change: tuple[str, str], arguments: tuple[str, ...], words: str) -> None:
    (folder / "s.toml").write_text(SCENARIO.replace(*change) if change[0] else SCENARIO)
    result = run("costs", folder / "s.toml", "--out", folder / "s.json", *arguments)
    assert isinstance(result.exception, InputError)
    with pytest.raises(InputError, match=words):
        raise result.exception
    assert not (folder / "s.json").exists()


def test_an_unreachable_task_is_named_with_where_from(folder: Path) -> None:
    wall = {
        "type": "Polygon",
        "coordinates": [[[0, 6000], [4000, 6000], [4000, 10000], [3800, 10000], [3800, 6200], [0, 6200], [0, 6000]]],
    }
    (folder / "zones.geojson").write_text(json.dumps(wall))
    result = run("costs", folder / "s.toml", "--out", folder / "s.json")
    with pytest.raises(InputError, match=r"tasks\[0\] = \[2000.0, 8000.0\] cannot be reached from depots\[0\]"):
        raise result.exception  # type: ignore[misc]


def test_a_wind_grid_that_does_not_cover_the_region_is_refused(folder: Path) -> None:
    header = "ncols 3\nnrows 3\nxllcenter 0\nyllcenter 0\ncellsize 4000\n"
    (folder / "w_vel.asc").write_text(header + "5 5 5\n" * 3)
    (folder / "w_ang.asc").write_text(header + "45 45 45\n" * 3)
    text = SCENARIO[: SCENARIO.index("[wind]")] + '[wind]\nkind = "grid"\nfile = "w_vel.asc"\n'
    (folder / "s.toml").write_text(text)
    result = run("costs", folder / "s.toml", "--out", folder / "s.json")
    with pytest.raises(InputError, match=r"the wind covers \(0, 0\) to \(8000, 8000\) m and not all of the region"):
        raise result.exception  # type: ignore[misc]


def test_a_strong_potential_wind_is_gauged_away(folder: Path) -> None:
    text = SCENARIO[: SCENARIO.index("[wind]")] + '[wind]\nkind = "uniform"\nvelocity = [30.0, 5.0]\n'
    (folder / "s.toml").write_text(text)
    result = run("costs", folder / "s.toml", "--out", folder / "s.json")
    assert result.exit_code == 0, result.output
    instance = read_instance(folder / "s.json")
    assert (instance.cost >= 0).all()
    assert len(instance.provenance["node_potential"]) == 6
    calm = folder / "calm.toml"
    calm.write_text(SCENARIO[: SCENARIO.index("[wind]")])
    run("costs", calm, "--out", folder / "calm.json")
    legs = ([0, 1, 2, 3], [1, 2, 3, 0])
    assert instance.cost[legs].sum() == pytest.approx(read_instance(folder / "calm.json").cost[legs].sum(), rel=1e-12)


def test_times_are_costs_of_their_own(folder: Path) -> None:
    timed = SCENARIO.replace("ground_speed = 20.0", 'cost = "time"\nairspeed = 20.0')
    (folder / "t.toml").write_text(timed)
    result = run("costs", folder / "t.toml", "--out", folder / "t.json", "--option", "samples=300")
    assert result.exit_code == 0, result.output
    for words in ("cost: flight time at a constant airspeed of 20 m/s", "not that none is cheaper"):
        assert words in result.stdout
    assert read_instance(folder / "t.json").provenance["moving_cost"]["cost"] == "time"
    assert run("check", folder / "t.paths.json.gz").exit_code == 0
    (folder / "t.toml").write_text(SCENARIO)
    result = run("check", folder / "t.paths.json.gz")
    assert (result.exit_code, "The instance's costs are 'time', those of the scenario 'energy'" in result.output) == (
        1,
        True,
    )
    (folder / "t.toml").write_text(timed)
    result = run("solve", folder / "t.json", "--solver", "greedy", "--time-limit", "5")
    for words in ("s of flight at constant airspeed", "energy cost", "in calm air"):
        assert words in result.stdout
