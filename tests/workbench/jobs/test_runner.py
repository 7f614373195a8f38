"""Whatever a solver does, the parent gets a Run in which every number has been verified."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np
import psutil
import pytest

from formulations.limits import Limits
from formulations.routing.solver import Status
from instances import Instance, makespan
from instances.compilation import told_to
from reports.record import Run, run_from
from workbench.jobs.job import Job, folder_of
from workbench.jobs.process import child
from workbench.jobs.process.child import InterruptedRunError, grace
from workbench.jobs.process.tree import Tree
from workbench.jobs.runner import refute_bound, run
from workbench.problems.routing import ROUTING, refute_cost, refute_proof


@pytest.fixture
def finish(instance, monkeypatch):
    """Run a misbehaving solver, with the grace shortened to one second."""
    monkeypatch.setattr(child, "grace", lambda limit: 1.0)

    def go(name: str, time_limit: float = 0.5, options: dict | None = None, **kwargs) -> Run:
        job = Job(folder_of(instance), f"misbehaving:{name}", options or {}, time_limit=time_limit)
        found = run(ROUTING, job, instance, **kwargs)
        assert run_from(json.loads(found.to_json())) == found  # whatever happened can be stored
        return found

    return go


@pytest.fixture
def all_with_first(instance) -> float:
    return makespan(instance, [list(instance.tasks), []])


def test_an_honest_run(finish, all_with_first):
    found = finish("Honest")
    assert (found.status, found.stopped_by) == (Status.FEASIBLE, "finished")
    assert found.objective == found.claimed_objective == all_with_first
    assert found.own["tour_costs"] == [all_with_first, 0.0]
    assert [cost for _, cost, _ in found.trace] == [all_with_first]
    assert found.wall_elapsed > found.prepare_elapsed > 0
    assert found.peak_memory > 1e6
    assert not found.proves


def test_a_crash_keeps_what_was_streamed(finish, all_with_first):
    found = finish("Crashes")
    assert (found.status, found.stopped_by) == (Status.ERROR, "error")
    assert found.message == "RuntimeError: the dog ate the basis matrix"
    assert "Traceback" in found.log
    assert (found.objective, found.bound) == (all_with_first, 1.0)


def test_a_segmentation_fault(finish, all_with_first):
    found = finish("Segfaults")
    assert found.status == Status.ERROR
    assert "SIGSEGV" in found.message
    assert found.objective == all_with_first


def test_an_exit_without_a_result(finish):
    found = finish("ExitsQuietly")
    assert (found.status, found.message) == (Status.ERROR, "ended with exit code 0 and without a result")


def test_a_hang_is_killed_with_its_whole_group(finish, all_with_first):
    found = finish("Hangs")
    assert (found.status, found.stopped_by) == (Status.KILLED, "killed")
    assert "ignored its time limit of 0.5 s" in found.message
    assert (found.objective, found.bound) == (all_with_first, 1.0)
    assert found.elapsed >= 1.5
    grandchild = int(found.log.split("grandchild")[1])
    assert ends(grandchild)


def ends(pid: int) -> bool:
    """Return whether a process that was sent SIGKILL ends within 10 s."""
    until = time.monotonic() + 10
    while time.monotonic() < until:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.02)
    return False


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("LiesAboutCost", "claimed a longest tour of"),
        ("LiesWhileStreaming", "claimed a longest tour of 1.0 s, but its routes cost"),
        ("ForgetsATask", "Task 0 is visited by no route"),
        ("ClaimsOptimalWithGap", "claimed OPTIMAL, but its routes cost"),
        ("BoundAboveRoutes", "claimed a bound of"),
        ("NoRoutes", "gave no routes"),
        ("WritesIntoEveryPipe", "sent an unreadable message: 'rubbish'"),
        ("ReturnsRubbish", "TypeError: solve returned str 'banana', not a Result"),
    ],
)
def test_a_false_claim_becomes_an_error(finish, name, words):
    found = finish(name)
    assert found.status == Status.ERROR
    assert words in found.message
    assert found.bound is None
    assert all(bound is None for _, _, bound in found.trace)


def test_a_wrong_cost_is_told_with_both_numbers(finish, all_with_first):
    found = finish("LiesAboutCost")
    assert repr(all_with_first) in found.message
    assert repr(0.5 * all_with_first) in found.message
    assert (found.objective, found.claimed_objective) == (all_with_first, 0.5 * all_with_first)


def test_printed_rubbish_is_only_a_log(finish, all_with_first):
    found = finish("PrintsRubbish")
    assert (found.status, found.objective) == (Status.FEASIBLE, all_with_first)
    assert found.log.endswith("the end")
    assert len(found.log) <= child.LOG_KEPT


def test_a_flood_of_events_is_thinned(finish, all_with_first):
    found = finish("Chatters", 60)
    assert found.bound == pytest.approx(0.9999 * all_with_first)
    assert len(found.trace) < 5000
    assert found.trace[-1][1:] == (found.objective, found.bound)


def test_a_memory_eater_is_killed(finish, all_with_first):
    found = finish("EatsMemory", 60, memory_limit=300 * 2**20)
    assert (found.status, found.stopped_by) == (Status.KILLED, "memory")
    assert found.objective == all_with_first
    assert found.peak_memory > 300 * 2**20


def test_a_solver_that_declines_says_why(finish):
    found = finish("Declines")
    assert (found.status, found.stopped_by) == (Status.NO_SOLUTION, "declined")
    assert "it only likes prime numbers" in found.message


def test_preparation_has_a_limit_of_its_own(finish, monkeypatch):
    monkeypatch.setattr(child, "PREPARE_WALL", 0.01)
    monkeypatch.setattr(child, "TICK", 0.001)  # a start takes longer than a look at the clock, however fast the machine
    found = finish("Honest")
    assert (found.status, found.own["routes"]) == (Status.KILLED, None)
    assert "still preparing" in found.message


def test_an_unknown_solver_is_an_error_of_the_run(instance):
    found = run(ROUTING, Job(folder_of(instance), "no_such_module:Solver", time_limit=1), instance)
    assert found.status == Status.ERROR
    assert "no_such_module" in found.message


def test_stop_kills_and_stores_nothing(finish):
    began = time.monotonic()
    with pytest.raises(InterruptedRunError):
        finish("Hangs", 60, stop=lambda: time.monotonic() - began > 0.6)


def test_a_child_dies_with_its_parent(instance_file, tmp_path):
    """kill −9 of the parent leaves no solver behind."""
    program = "import sys; from workbench.cli import main; main(sys.argv[1:])"
    args = ["solve", str(instance_file), "--solver", "misbehaving:Honest", "--option", "delay=50"]
    parent = subprocess.Popen([sys.executable, "-c", program, *args], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    assert parent.stderr is not None
    assert "longest tour" in parent.stderr.readline()
    (solver,) = psutil.Process(parent.pid).children()
    parent.kill()
    parent.wait()
    parent.stderr.close()
    gone, _ = psutil.wait_procs([solver], timeout=10)
    assert gone == [solver]


def test_the_grace_is_five_seconds_and_a_tenth():
    assert grace(100) == 15


def test_verification_forgives_rounding_only():
    assert not refute_cost(100.0 + 1e-8, 100.0)
    assert refute_cost(100.0 + 1e-6, 100.0)
    assert refute_cost(float("nan"), 100.0)
    assert refute_cost(1e-6, 1.1e-6)
    assert not refute_bound(100.0 + 1e-8, 100.0)
    assert refute_bound(100.0 + 1e-6, 100.0)
    assert refute_bound(-99.0, -100.0)
    assert not refute_proof(Status.OPTIMAL, 99.95, 100.0, tolerance=0.05)
    assert refute_proof(Status.OPTIMAL, 99.94, 100.0, tolerance=0.05)
    assert refute_proof(Status.OPTIMAL, 99.5, 100.0, tolerance=0.5)  # 0.5 % is no proof
    assert refute_proof(Status.OPTIMAL, None, 100.0, tolerance=0.5)
    assert refute_proof(Status.OPTIMAL, 99.9, 100.0, tolerance=float("nan"))


def test_costs_of_any_size(monkeypatch):
    for size in (1e-6, 1e9):
        drawn = Instance("scaled", size * (1 - np.eye(3)), 2, 1)
        found = run(ROUTING, Job(folder_of(drawn), "misbehaving:Honest", time_limit=1), drawn)
        assert found.objective == pytest.approx(3 * size)
        lie = Job(folder_of(drawn), "misbehaving:LiesAboutCost", time_limit=1)
        assert run(ROUTING, lie, drawn).status == Status.ERROR


def test_limits_are_checked_before_a_process_is_started(instance):
    with pytest.raises(ValueError, match="time limit must be positive"):
        Limits(time=0)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("StreamsAFalseBound", "claimed a bound of"),
        ("ClaimsInfeasible", "claimed INFEASIBLE, but one UAV can fly all tasks in"),
        ("ClaimsInfeasibleBesideRoutes", "claimed INFEASIBLE, but gave routes of"),
    ],
)
def test_a_false_proof_becomes_an_error(finish, name, words):
    found = finish(name)
    assert (found.status, found.bound) == (Status.ERROR, None)
    assert words in found.message


@pytest.mark.parametrize("product", ["[[Infinity]]", "{}", f"[[{'9' * 400}], []]"], ids=lambda p: p[:9])
def test_a_forged_message_becomes_an_error(finish, all_with_first, product):
    """All other forgeries: test_messages.py; they take the same way."""
    line = '{"kind": "event", "claim": {"product": PRODUCT, "objective": 1.0}}'.replace("PRODUCT", product)
    found = finish("Says", options={"line": line})
    assert (found.status, found.objective) == (Status.ERROR, all_with_first)
    assert len(found.message) < 2100


def test_a_message_out_of_turn_becomes_an_error(finish):
    """Said again and again, "prepared" would put off the end of the run."""
    found = finish("Says", options={"line": '{"kind": "prepared"}', "times": 3})
    assert (found.status, found.message[:50]) == (Status.ERROR, "sent an unreadable message: 'prepared', which cann")


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("tolerance", "nan", "claimed a tolerance of nan, which is not a finite number"),
        ("tolerance", "inf", "claimed a tolerance of inf"),
        ("bound", "inf", "claimed a bound of inf"),
        ("objective", "nan", "claimed a objective of nan"),
        ("bound", "digits", "OverflowError"),
        ("statistics", "large", "statistics of 400007 bytes"),
        ("status", "lone", "'\\ud800' is not a valid Status"),
    ],
)
def test_a_result_with_a_field_that_is_none_becomes_an_error(finish, all_with_first, field, value, words):
    found = finish("Returns", options={"field": field, "value": value})
    assert (found.status, found.objective) == (Status.ERROR, all_with_first)
    assert words in found.message


def test_statistics_are_spelled_out(finish):
    assert "{'in': " in str(finish("Returns", options={"field": "statistics", "value": "deep"}).statistics)


@pytest.mark.parametrize("delay", [0.0, 0.7])
def test_nothing_a_run_started_outlives_it(finish, delay):
    """A process in another session and one whose parent has ended, while the run ends well."""
    found = finish("LeavesProcesses", options={"delay": delay})
    assert found.status == Status.FEASIBLE
    left = [int(pid) for pid in found.log.split() if pid.isdigit()]
    assert len(left) == 2
    assert not any(psutil.pid_exists(pid) for pid in left)
    assert found.cpu_seconds > 0.1 * delay  # theirs counts, and the run itself slept


def test_memory_of_a_process_in_another_session_counts(finish):
    found = finish("GrandchildEatsMemory", 60, memory_limit=400 * 2**20)
    assert (found.status, found.stopped_by) == (Status.KILLED, "memory")
    assert 400e6 < found.peak_memory < 2e9


def test_a_run_that_kills_its_keeper_leaves_nothing(finish):
    found = finish("KillsItsParent", 60)
    assert (found.status, found.stopped_by) == (Status.KILLED, "killed")
    assert found.message == "was killed from outside (SIGKILL)"
    assert ends(int(found.log.split("left")[1]))


def test_a_run_that_stops_its_keeper_is_killed(finish, all_with_first):
    found = finish("StopsItsParent")
    assert (found.status, found.objective) == (Status.KILLED, all_with_first)
    assert "ignored its time limit" in found.message


def test_the_clock_is_ours(finish):
    found = finish("TurnsClocksBack")
    assert 0 < found.elapsed < 5  # by the run's clocks -5000 or no time at all; ours may hear late that it began
    assert all(0 <= elapsed < 5 for elapsed, _, _ in found.trace)


def test_preparing_has_a_limit_of_processor_time(finish, monkeypatch):
    monkeypatch.setattr(child, "PREPARE_CPU", 1.0)
    found = finish("SpinsWhilePreparing")
    assert found.status == Status.KILLED
    assert "s of processor time" in found.message


def test_a_run_killed_together_with_its_study_is_not_stored(finish, monkeypatch):
    """The run's processes are killed first, its parent is told to stop a moment later."""
    ended: list[float] = []
    monkeypatch.setattr(Tree, "close", lambda tree: ended.append(time.monotonic()))
    with pytest.raises(InterruptedRunError):
        finish("KillsItsParent", 60, stop=lambda: bool(ended) and time.monotonic() - ended[0] > 0.3)


@pytest.mark.parametrize("name", ["Honest", "DiesCompiling"])
def test_who_waits_is_told_of_compilations_in_a_run(finish, name):
    told: list[bool] = []
    with told_to(told.append):
        finish(name)
    assert told == ([True, False] if name == "DiesCompiling" else [])
