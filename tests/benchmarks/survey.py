"""Surveys that learn: the measured figures beside their bars. Run by hand, all bars or those named:

    python tests/benchmarks/survey.py [se-draws] [radio] [jacksboro] [mission] [polish] [drift] [replan] [bound]
        [--seeds 12]

se-draws, radio, jacksboro: the map's kernel chosen by likelihood; mission: the paper's against the lawnmower; polish,
replan: survey planners, polish beside what no tours can pass; drift: polish for a field that drifts; bound: the average
variance's lower bound. `workbench compare survey` compares planners.
Intervals are 95 %, Student's t of paired differences; times are processor seconds of this process.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from jacksboro import KML, write_mission
from msgspec import structs
from scipy.optimize import minimize
from se_map import judged

from formulations.average_variance import AverageVariance
from formulations.kernel import KERNELS, SquaredExponential
from formulations.limits import Limits
from formulations.mapping.gaussian_process import GaussianProcess
from formulations.mapping.map_grid import MapGrid
from formulations.mapping.map_model import EVERY_KERNEL, MapModel, Offered, choose_model
from formulations.mapping.survey import Score, score
from formulations.path_bound import path_bound
from formulations.polish.path_polish import PolishProblem
from formulations.polish.path_polish import polish as polish_paths
from formulations.surveying.adaptive import Adaptive, replanned
from formulations.surveying.gaussian_field import gaussian_field
from formulations.surveying.polished import polish_problem, polished
from formulations.surveying.problem import Sensor, SurveyProblem, Tours, length_of
from formulations.surveying.registry import PLANNERS
from formulations.surveying.verification import measured, worth_of
from instances.environment.region import Region
from instances.scenario_folder import kept_field, kept_scenario
from reports.statistics.paired import Paired, paired
from workbench.mission.belief import belief_of
from workbench.mission.file import read_mission, shipped_missions
from workbench.mission.flight import kept_flights
from workbench.mission.pipeline import NAMES
from workbench.mission.redraw import conditions

SQUARE = Region.rectangle(20_000.0, 20_000.0)
DEPOTS = np.array([[10_000.0, 19_000.0], [1_000.0, 1_000.0], [19_000.0, 1_000.0]])
POINTS = MapGrid.over(SQUARE, 50).points
SMOOTH = Offered((KERNELS["se"],))
JACKSBORO = """name = "jacksboro"
ground_speed = 30.0
region = "area.kml"
terrain = "dem.tif"
depots = [[-84.246, 36.71], [-84.39, 36.465], [-84.105, 36.465]]
tasks = 40
[wind]
kind = "terrain"
dem = "dem.tif"
velocity = [-7.0711, -7.0711]
profile = "log"
altitude = 1500.0
[radio]
position = [-84.246, 36.590]
[field]
model = "itm"
shadowing_sd = 0.0
[flight]
altitude = 1500.0
[sensing]
period = 33.0
"""
AREA = {"west": -84.4025, "south": 36.4545, "east": -84.0895, "north": 36.7245}
"""28 by 30 km."""


def say(what: str, measured: str, bar: str, kept: bool) -> None:
    """Print a figure beside its bar."""
    print(f"{'ok  ' if kept else 'MISS'} {what}: {measured} (bar: {bar})", flush=True)


def interval(found: Paired) -> str:
    """Return a relative difference with its interval."""
    return f"{found.mean:+.1%} ({found.low:+.1%} to {found.high:+.1%}, lower in {found.negative} of {found.pairs})"


def problem(length: float, believed: float = 4000.0) -> SurveyProblem:
    """Return the paper's square; length : most a UAV may fly [m]; believed : length scale [m]."""
    return SurveyProblem(SQUARE, DEPOTS, length, 1000.0, kernel(believed), 1.0)


def kernel(length_scale: float) -> SquaredExponential:
    """Return the paper's."""
    return SquaredExponential(30.0, (length_scale, length_scale))


def planned(name: str, given: SurveyProblem, truth: Callable[[np.ndarray], np.ndarray], seed: int) -> Tours:
    """Return the tours of a planner."""
    planner = PLANNERS.make(name)
    planner.prepare(given)
    return planner.plan(given, Sensor(truth, given.noise_sd, seed), limits=Limits(), seed=0)


def mapped(offered: Offered, X: np.ndarray, y: np.ndarray, points: np.ndarray, truth: np.ndarray) -> Score:
    """Return the score of the map chosen among `offered`, σ_n = 1."""
    process = GaussianProcess(choose_model(MapModel(kernel(4000.0)), offered, 1.0, X, y).model, 1.0, points)
    process.extend(X, y)
    return score(process.posterior(), truth, 1.0)


def se_draws(seeds: int) -> None:
    """On draws of the squared exponential the choice must cost nothing."""
    given, rmse = problem(49_200.0), []
    tours = planned("workbench", given, lambda p: np.zeros(len(p)), 0)
    for seed in range(seeds):
        field = gaussian_field(given.kernel, SQUARE.bounds, 100, seed)
        X, y = measured(given, tours, field, seed)
        rmse.append([mapped(offered, X, y, POINTS, field(POINTS)).rmse for offered in (EVERY_KERNEL, SMOOTH)])
    auto, smooth = np.array(rmse).T
    found = paired((auto - smooth) / smooth.mean())
    say(f"SE draws, {seeds} seeds: auto {auto.mean():.3f} against SE {smooth.mean():.3f}", interval(found),
        "within 1 %", abs(found.mean) <= 0.01)  # fmt: skip


def flown(text: str, folder: Path, last: str) -> Path:
    """Run a mission to its stage `last`; return its products."""
    (folder / "mission.toml").write_text(text)
    program = [sys.executable, "-P", "-c", "from workbench.cli import main; main()"]
    for stage in NAMES[: NAMES.index(last) + 1]:
        words = ["mission", "mission.toml", "--out", "out", "--stage", stage]
        subprocess.run([*program, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder / "out"


def paper(seeds: int) -> str:
    """Return the paper's mission over so many seeds, against the lawnmower alone."""
    told = shipped_missions()["paper"].read_text(encoding="utf-8")
    return f'{told}\n[compare]\nseeds = {seeds}\nbaselines = ["lawnmower"]\n'


def readings(mission, out: Path, field, seed: int) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[no-untyped-def]
    """Return what the mission's flights read of `field` with noise of `seed`."""
    tours = kept_flights(out / "5-flight")
    X = np.concatenate([flight.measurements(mission.sensing.period)[1] for flight in tours])
    return X, field(X) + np.random.default_rng(seed).normal(0.0, mission.sensing.noise_sd, len(X))


def radio(seeds: int) -> None:
    """The paper's radio mission: coverage, and RMSE against the map as it was."""
    with tempfile.TemporaryDirectory() as folder:
        out = flown(paper(seeds), Path(folder), "flight")
        mission = read_mission(Path(folder) / "mission.toml")
        points = MapGrid.over(kept_scenario(out / "1-environment").region, mission.map.cells).points
        rows = []
        for field, seed in conditions(mission, kept_field(out / "1-environment")):
            X, y = readings(mission, out, field, seed)
            auto = mapped(EVERY_KERNEL, X, y, points, field(points))
            rows.append([auto.rmse, auto.coverage, judged(1.0, X, y, points, field(points)).rmse])
    rmse, covered, before = np.array(rows).T
    say("paper.toml, coverage in the mean", f"{covered.mean():.3f}", "0.90 to 0.98", 0.9 <= covered.mean() <= 0.98)
    say("paper.toml, coverage of any seed", f"{covered.min():.3f}", "at least 0.85", covered.min() >= 0.85)
    found = paired((rmse - before) / before.mean())
    say(f"paper.toml, RMSE {rmse.mean():.2f} against {before.mean():.2f} of the SE map by ML", interval(found),
        "-20 %", found.mean <= -0.2)  # fmt: skip


def jacksboro(seeds: int) -> None:
    """Over the Jacksboro fault, ITM's signal: kernel alone, and with the diffraction as mean; means over noise.

    Tours as they are by default, and beside them tours with their paths polished.
    """
    for tours, more in (("", ""), (", polished", "[place]\npolish = true\n")):
        with tempfile.TemporaryDirectory() as folder:
            write_mission(Path(folder))
            (Path(folder) / "area.kml").write_text(KML.format(**AREA))
            _jacksboro(flown(JACKSBORO + more, Path(folder), "flight"), f"Jacksboro{tours}", seeds)


def _jacksboro(out: Path, name: str, seeds: int) -> None:
    mission, field = read_mission(out.parent / "mission.toml"), kept_field(out / "1-environment")
    points = MapGrid.over(kept_scenario(out / "1-environment").region, mission.map.cells).points
    for mean, bar in (("constant", 3.0), ("propagation", 2.0)):
        wanted = replace(mission, map=structs.replace(mission.map, mean=mean))
        offered = belief_of(wanted, out / "1-environment").offered
        each = [readings(mission, out, field, seed) for seed in range(seeds)]
        rmse = np.array([mapped(offered, X, y, points, field(points)).rmse for X, y in each])
        spread = f"{rmse.mean():.2f} dBm ({rmse.min():.2f} to {rmse.max():.2f} over {seeds} noise seeds)"
        say(f"{name}, mean {mean}", spread, f"at most {bar}", rmse.mean() <= bar)
    X, y = readings(mission, out, field, 0)
    print(f"     the SE map by ML: {judged(1.0, X, y, points, field(points)).rmse:.2f} dBm, {len(X)} readings")


def mission(seeds: int) -> None:
    """The paper's mission, default settings, against a lawnmower that is at least as long."""
    with tempfile.TemporaryDirectory() as folder:
        out = flown(paper(seeds), Path(folder), "compare")
        rows = list(csv.DictReader((out / "7-compare" / "compare-draws.csv").open()))
    by = {name: [row for row in rows if row["name"] == name] for name in ("mission", "lawnmower")}
    own, other = (np.array([float(row["rmse"]) for row in each]) for each in by.values())
    longer = float(by["lawnmower"][0]["length"]) / float(by["mission"][0]["length"]) - 1
    found = paired(own - other)
    say(f"mission {own.mean():.3f} against lawnmower {other.mean():.3f} dBm, which is {longer:+.0%} long",
        f"{found.mean:+.3f} ({found.low:+.3f} to {found.high:+.3f} dBm, lower in {found.negative} of {found.pairs})",
        "interval below 0", found.high < 0 and longer >= 0)  # fmt: skip


def polish(seeds: int) -> None:
    """Polished tours: what they promise, what they take, and the map of GP draws."""
    for length, bar, other in ((49_200.0, 0.81, 0.97), (30_000.0, 3.0, 3.91)):
        given = problem(length)
        began = time.process_time()
        before = planned("workbench", given, np.sum, 0)
        placed, began = time.process_time() - began, time.process_time()
        tours = planned("polished", given, np.sum, 0)
        took = time.process_time() - began - placed
        fields = [gaussian_field(given.kernel, SQUARE.bounds, 100, seed) for seed in range(seeds)]
        own, old = ([worth_of(given, t, f, POINTS, s) for s, f in enumerate(fields)] for t in (tours, before))
        name = f"{length / 1e3:g} km, polish"
        say(f"{name}: √J (from {old[0].promised_sd:.3f})", f"{own[0].promised_sd:.3f}", f"{bar}",
            own[0].promised_sd <= bar)  # fmt: skip
        say(f"{name}: processor time [s]", f"{took:.1f}", "8", took <= 8.0)
        longest = max(map(length_of, tours))
        say(f"{name}: longest tour [m]", f"{longest:.1f}", f"{length:g}", longest <= length)
        rmse = np.array([each.score.rmse for each in own])
        found = paired(rmse / np.mean([each.score.rmse for each in old]) - [o.score.rmse / np.mean(
            [each.score.rmse for each in old]) for o in old])  # fmt: skip
        say(f"{name}: RMSE over {seeds} GP draws", f"{rmse.mean():.3f}; against before {interval(found)}",
            f"{other}, sgptools with free ends on other draws", rmse.mean() < other)  # fmt: skip
        judged_by = AverageVariance(given.kernel, given.noise_sd, given.targets)
        began = time.process_time()
        least = path_bound(judged_by, SQUARE, DEPOTS, length, given.spacing) ** 0.5
        took = time.process_time() - began
        alone = judged_by.lower_bound(len(DEPOTS) * int(length / given.spacing)) ** 0.5
        print(f"     no tours so long have √J below {least:.3f} ({least / own[0].promised_sd:.0%} of that reached; "
              f"{alone:.3f} by the number of readings alone), {took:.1f} s")  # fmt: skip


def drift(seeds: int) -> None:
    """What polish that knows τ promises of a field that drifts, beside polish for one that stays; 100 m/s."""
    given = problem(49_200.0)
    before, budgets = planned("workbench", given, np.sum, 0), np.full(len(DEPOTS), given.length)

    def asked_with(tau: float) -> PolishProblem:
        judged = AverageVariance(given.kernel, given.noise_sd, given.targets, tau=100.0 * tau)  # speed is 1 m/s there
        return polish_problem(given, judged, before, budgets)

    still = polished(given, before)
    for tau in (300.0, 1000.0, 3000.0):
        knowing = asked_with(tau)
        began = time.process_time()
        found = polish_paths(knowing).paths
        took = time.process_time() - began
        old, stays, known = (knowing.value(paths) ** 0.5 for paths in (before, still, found))
        say(f"τ = {tau:g} s, √J at the end of 49.2 km: {old:.2f} unpolished, {stays:.2f} polished as if it stayed",
            f"{known:.2f} knowing τ, {took:.1f} s", "lower", known < stays)  # fmt: skip


BELIEVED = {10_000.0: "at least 30 % lower", 4_000.0: "within 3 %", 1_600.0: "lower"}
"""Length scale believed before take-off [m] → what re-planning is to change where it is 4 km."""


def replan(seeds: int) -> None:
    """Plans changed in flight against the same not changed, of whole tasks and polished, all mapped alike."""
    for believed in asked.believed or BELIEVED:
        given, longest, took = problem(49_200.0, believed), 0.0, list[float]()
        tests = given.region.cell_centres(10, 10)
        once = planned("workbench", given, np.sum, 0)
        start, rmse = {False: once, True: polished(given, once)}, {False: list[list[float]](), True: []}
        for seed in range(seeds):
            field = gaussian_field(kernel(4000.0), SQUARE.bounds, 100, seed)
            for polish, tours in start.items():
                sensor = Sensor(field, given.noise_sd, seed)
                flown, made = replanned(given, tours, sensor, tests, every=Adaptive.every, polish=polish)
                both = [worth_of(given, each, field, POINTS, seed) for each in (tours, flown)]
                rmse[polish].append([each.score.rmse for each in both])
                longest = max(longest, both[1].longest)
                took += [each.elapsed for each in made if polish]
        for polish, rows in rmse.items():
            before, after = np.array(rows).T
            found = paired((after - before) / before.mean())
            kept = {10_000.0: found.mean <= -0.3, 4_000.0: abs(found.mean) <= 0.03}.get(believed, found.high < 0)
            say(f"believed {believed:g} m, true 4000 m, {'polished' if polish else 'whole tasks'}: "
                f"{before.mean():.3f} once, {after.mean():.3f} adaptive",
                interval(found), BELIEVED[believed], kept)  # fmt: skip
        first, last = np.array(rmse[False])[:, 0], np.array(rmse[True])[:, 1]
        print(f"     polished and adaptive against whole tasks once: {interval(paired((last - first) / first.mean()))}")
        say("     longest tour [m]", f"{longest:.1f}", "49200", longest <= 49_200.0)
        say("     a re-plan with polish [s]", f"{np.mean(took):.2f}, at most {max(took):.2f}", "1.5", max(took) <= 1.5)


def bound(seeds: int) -> None:
    """√bound/√best of the average variance on the 20 × 20 grid; best of `seeds` starts of L-BFGS-B."""
    judged_by = AverageVariance(kernel(4000.0), 1.0, SQUARE.cell_centres(20, 20))

    def lowered(start: np.ndarray) -> float:
        def value(flat: np.ndarray) -> tuple[float, np.ndarray]:
            J, slope = judged_by(4000.0 * flat.reshape(-1, 2))
            return np.log(J), 4000.0 * slope.ravel() / J

        box = [(0.0, 5.0)] * start.size
        return float(np.exp(minimize(value, start.ravel() / 4000.0, jac=True, method="L-BFGS-B", bounds=box).fun))

    for count in (5, 10, 20, 40):
        best = min(lowered(SQUARE.sample(count, np.random.default_rng(seed))) for seed in range(seeds))
        low = judged_by.lower_bound(count)
        share = np.sqrt(low / best)
        say(f"n = {count}: √bound {np.sqrt(low):.3f}, √best {np.sqrt(best):.3f}", f"{share:.3f}", "at least 0.79",
            share >= 0.79)  # fmt: skip


BARS: dict[str, Callable[[int], None]] = {
    "se-draws": se_draws, "radio": radio, "jacksboro": jacksboro, "mission": mission, "polish": polish,
    "drift": drift, "replan": replan, "bound": bound,
}  # fmt: skip

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bars", nargs="*", choices=[[], *BARS], help="those to measure, all unless given")
    parser.add_argument("--believed", type=float, action="append", choices=BELIEVED, help="of replan, all unless given")
    parser.add_argument("--seeds", type=int, default=12, help="fields and noise")
    asked = parser.parse_args()
    for each in asked.bars or BARS:
        BARS[each](asked.seeds)
