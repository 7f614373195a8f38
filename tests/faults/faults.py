"""Every hostile plug-in with what must come of it: status, and words of the sentence that is stored."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from tests.faults.hostile_messages import LINES

ERROR, KILLED, FEASIBLE, NONE = "ERROR", "KILLED", "FEASIBLE", "NO_SOLUTION"


@dataclass(frozen=True)
class Fault:
    """One hostile plug-in: `module:Class`, its options, the statuses it may end with, and words of its message.

    quick : whether it is in the suite that runs every time; kind : "solve"; "prepare" or "memory" where the limits on
    these are lowered; "keeper" where the process between study and run is killed.
    """

    method: str
    statuses: tuple[str, ...]
    words: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    quick: bool = False
    kind: str = "solve"

    @property
    def name(self) -> str:
        """What a test is called."""
        values = [str(value)[:40] for value in self.options.values()]
        return " ".join([self.method.removeprefix("tests.faults.hostile_"), *values])


def _claims(name: str, words: str, *statuses: str, quick: bool = False, **options: str) -> Fault:
    return Fault(f"tests.faults.hostile_claims:{name}", statuses or (ERROR,), words, options, quick)


def _gives(nodes: str, words: str) -> Fault:
    return _claims("Gives", words, nodes=nodes)


def _returns(field_: str, value: str, words: str, *statuses: str) -> Fault:
    return _claims("Returns", words, *statuses, field=field_, value=value)


def _raises(error: str, words: str) -> Fault:
    return _claims("Raises", words, error=error)


def _process(name: str, *statuses: str, words: str = "", quick: bool = False, kind: str = "solve") -> Fault:
    return Fault(f"tests.faults.hostile_processes:{name}", statuses, words, {}, quick, kind)


CLAIMS = (
    _claims("bound_streamed_too_high", "claimed a bound of", quick=True),
    _claims("bound_in_the_end_too_high", "claimed a bound of"),
    _claims("optimal_without_bound", "claimed OPTIMAL without a bound"),
    _claims("optimal_without_routes", "gave no routes"),
    _claims("optimal_with_gap", "claimed OPTIMAL, but its routes cost"),
    _claims("optimal_within_anything", "claimed OPTIMAL with a tolerance of"),
    _claims("infeasible_beside_routes", "claimed INFEASIBLE, but gave routes", quick=True),
    _claims("Infeasible", "claimed INFEASIBLE, but one UAV can fly all tasks"),
    _gives("(0, 0)", "Task 0"),
    _gives("(4,)", "4"),
    _gives("(-1,)", "-1"),
    _gives("(10**6,)", "1000000"),
    _gives("(10**30,)", "not a task"),
    _gives("()", "Task 0 is visited by no route"),
    _claims("too_few_routes", "the routes are not feasible"),
    _claims("too_many_routes", "the routes are not feasible"),
    _claims("routes_are_a_text", ""),
    _claims("routes_of_fractions", "TypeError"),
    _returns("objective", "math.nan", "objective"),
    _returns("objective", "math.inf", "objective"),
    _returns("objective", "10**400", ""),
    _returns("objective", "'5'", ""),
    _returns("bound", "math.nan", "bound"),
    _returns("bound", "math.inf", "bound"),
    _returns("tolerance", "math.nan", "tolerance"),
    _returns("tolerance", "math.inf", "tolerance"),
    _returns("tolerance", "-1.0", "tolerance"),
    _returns("statistics", "{'x': np.array([np.nan, 1.0])}", "", ERROR, FEASIBLE),
    _returns("statistics", "{'x': 'y' * 30_000_000}", "", ERROR, FEASIBLE),
    _returns("statistics", "{str(i): i for i in range(1_000_000)}", "", ERROR, FEASIBLE, KILLED),
    _returns("statistics", "nested(100_000)", "", ERROR, FEASIBLE),
    _returns("statistics", "{'x': 10**400}", "", ERROR, FEASIBLE),
    _returns("statistics", "{'x': Evil()}", "", ERROR, FEASIBLE),
    _returns("statistics", "[1, 2]", ""),
    _returns("message", "chr(0xd800)", "", ERROR, FEASIBLE),
    _returns("message", "'[/b]' * 3 + chr(27) + '[31m' + chr(10)", "", ERROR, FEASIBLE),
    _returns("message", "'=cmd|calc<!--<script>$x_{'", "", ERROR, FEASIBLE),
    _returns("message", "'x' * 10_000_000", "", ERROR, FEASIBLE),
    _returns("stopped_by", "None", "", ERROR, FEASIBLE),
    _returns("status", "'CERTIFIED'", "CERTIFIED"),
    _returns("routes", "None", "gave no routes"),
    _returns("elapsed", "-4747.0", "", FEASIBLE),
    _claims("cost_is_half", "claimed a longest tour of"),
    _claims("cost_is_half_while_streaming", "claimed a longest tour of"),
    _claims("flood_of_events", "", FEASIBLE, KILLED),
    _claims("not_a_result", "not a Result"),
    _claims("an_evil_result", ""),
    _claims("Declines", "does not take", NONE, reason="'[/b]' + chr(0xd800) + chr(10) * 3"),
    _claims("Declines", "", NONE, ERROR, reason="5"),
    _raises("RuntimeError('the dog ate ' + chr(0xd800))", "RuntimeError: the dog ate"),
    _raises("OSError(__import__('os').fsdecode(b'\\xff'))", "OSError"),
    _raises("KeyboardInterrupt", ""),
    _raises("SystemExit(0)", ""),
    _raises("SystemExit('text')", ""),
    _raises("MemoryError", "MemoryError"),
    _raises("RecursionError", "RecursionError"),
    _raises("GeneratorExit", ""),
    _raises("type('Own', (BaseException,), {})()", ""),
)
MESSAGES = (
    *(
        Fault(  # what takes longer to write than the time limit is not read to its end
            "tests.faults.hostile_messages:Says",
            (ERROR, KILLED) if name.startswith("100 MB") else (ERROR,),
            "",
            {"line": name},
            name in ("infinite bound", "no text"),
        )
        for name in LINES
    ),
    Fault("tests.faults.hostile_messages:EventBeforePrepared", (ERROR,), "unreadable message"),
    Fault("tests.faults.hostile_messages:ResultWhileAsked", (ERROR,), ""),
    Fault("tests.faults.hostile_messages:ResultTwice", (ERROR,), ""),
    Fault("tests.faults.hostile_messages:PreparesForEver", (ERROR, KILLED), ""),
)
PROCESSES = (
    _process("leaves_a_session", FEASIBLE, quick=True),
    _process("leaves_a_daemon", FEASIBLE, quick=True),
    _process("leaves_a_spinner", FEASIBLE),
    _process("leaves_a_deaf_daemon", FEASIBLE),
    _process("leaves_what_has_forgotten_us", FEASIBLE),
    _process("leaves_a_chain", FEASIBLE),
    _process("forks_fifty", FEASIBLE),
    _process("forks_fifty_that_fork", KILLED, words="ignored its time limit"),
    _process("sleeps", KILLED, words="ignored its time limit", quick=True),
    _process("sleeps_deafly", KILLED, words="ignored its time limit"),
    _process("stops_itself", KILLED, words="ignored its time limit"),
    _process("stops_its_parent", FEASIBLE, KILLED, quick=True),
    _process("stops_its_parent_and_sleeps", KILLED),
    _process("kills_its_group", KILLED, ERROR),
    _process("kills_its_parent", KILLED, ERROR, kind="keeper"),
    _process("kills_its_parent_amid_forks", KILLED, ERROR, kind="keeper"),
    _process("kills_its_parent_unseen", KILLED, ERROR, kind="keeper"),
    _process("guarded_by_a_killer", KILLED, kind="keeper"),
    _process("kills_itself", KILLED, ERROR),
    _process("terminates_itself", KILLED, ERROR),
    _process("outlives_its_parent", KILLED, ERROR),
    _process("adopts", KILLED, words="ignored its time limit"),
    _process("closes_everything", ERROR),
    _process("closes_its_streams", FEASIBLE, ERROR),
    _process("exits_quietly", ERROR, words="without a result", quick=True),
    _process("exits", ERROR),
    _process("aborts", ERROR, words="SIGABRT"),
    _process("segfaults", ERROR, words="SIGSEGV", quick=True),
    _process("becomes_another_program", ERROR, words="without a result"),
    _process("leaves_a_thread", FEASIBLE),
    _process("sleeps_at_exit", FEASIBLE),
    _process("recurses", ERROR, KILLED),
    _process("dumps", FEASIBLE, ERROR),
    _process("loses_its_folder", FEASIBLE),
    _process("goes_elsewhere", FEASIBLE),
    _process("prints_gigabytes", KILLED, words="ignored its time limit"),
    _process("turns_clocks_back", FEASIBLE),
    _process("SolvesWhilePreparing", FEASIBLE),
    _process("lies_afterwards", FEASIBLE),
    _process("eats_memory", KILLED, words="more than its", kind="memory"),
    _process("orphan_eats_memory", KILLED, words="more than its", kind="memory"),
    _process("four_hold_memory", KILLED, words="more than its", kind="memory"),
    _process("SpinsWhilePreparing", KILLED, words="still preparing", kind="prepare"),
    _process("SleepsWhilePreparing", KILLED, words="still preparing", kind="prepare"),
    _process("ForksWhilePreparing", KILLED, words="still preparing", kind="prepare"),
)
IMPORTS = (
    Fault("no_such_module:Solver", (ERROR,), "no_such_module"),
    Fault("builtins:exit", (ERROR,), quick=True),
    Fault("builtins:NoSuch", (ERROR,), "NoSuch"),
    Fault("builtins:list", (ERROR,)),
    Fault("os:abort", (ERROR,)),
    Fault("os:fork", (ERROR,)),
    Fault("sys:exit", (ERROR,)),
    Fault("json:", (ERROR,)),
    Fault(":x", (ERROR,)),
    Fault("no such solver", (ERROR,), "no such solver"),
    Fault("broken_syntax:Solver", (ERROR,), "SyntaxError"),
    Fault("exits_at_import:Solver", (ERROR,)),
    Fault("quits_at_import:Solver", (ERROR,)),
    Fault("interrupts_at_import:Solver", (ERROR,)),
    Fault("daemon_at_import:Solver", (ERROR,)),
    Fault("signal:pause", (ERROR, KILLED), kind="prepare"),
    Fault("sleeps_at_import:Solver", (KILLED,), "still preparing", kind="prepare"),
)
MODULES = {
    "broken_syntax": "def (:",
    "exits_at_import": "import sys; sys.exit(0)",
    "quits_at_import": "import os; os._exit(0)",
    "interrupts_at_import": "raise KeyboardInterrupt",
    "daemon_at_import": "import os, time\nif os.fork() == 0:\n    os.setsid()\n    time.sleep(31415)\n",
    "sleeps_at_import": "import time; time.sleep(31415)",
}
"""Modules that are written for a test, as no tool that reads our sources should meet them."""
FAULTS = (*CLAIMS, *MESSAGES, *PROCESSES, *IMPORTS)
