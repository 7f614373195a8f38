"""Keeper: the small process between a study and one run, so that a run ends with all its processes.

    study ── keeper ── worker ── whatever the method starts

``python -P -m workbench.jobs.process.keeper MESSAGES LIFE`` forks the worker before anything heavy is imported. On
Linux the keeper is a child subreaper (man 2 prctl): what the method starts becomes the keeper's when its own parent
ends, in whatever session or group it is. When the worker has ended, or the pipe LIFE closes because the study ended the
run or died itself, the keeper kills what is left and ends the way the worker did. The kernel then tells the study the
processor time of them all.
"""

from __future__ import annotations

import contextlib
import gc
import os
import resource
import select
import signal
import sys
import time

from workbench.jobs.process.kernel import adopt_descendants, be_first_to_free_memory, die_with_parent

PATIENCE = 10.0
"""Seconds to wait for killed processes to be gone; one that hangs in the kernel may take longer."""
PAUSE = 0.002
"""Seconds between two looks at what is left."""


def main() -> None:
    """Fork the worker, wait for its end or for the order to end it, leave nothing behind."""
    messages, life = int(sys.argv[1]), int(sys.argv[2])
    adopt_descendants()
    wake, woken = os.pipe()
    for end in (wake, woken):
        os.set_blocking(end, False)
    signal.set_wakeup_fd(woken)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)  # before the fork: the worker may end at once
    keeper, worker = os.getpid(), os.fork()
    if worker == 0:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        for descriptor in (life, wake, woken):
            os.close(descriptor)
        _work(messages, keeper)
        return
    os.close(messages)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the study decides; it closes LIFE
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in range(3):
        os.dup2(nothing, descriptor)
    status = _watch(worker, life, wake)
    _end_all(worker)
    _end_like(status)


def _work(messages: int, keeper: int) -> None:
    """Be the worker: in a session of its own, killed when the keeper is."""
    os.setsid()
    die_with_parent()
    if os.getppid() != keeper:  # it was killed before we asked
        os._exit(1)
    be_first_to_free_memory()
    gc.disable()  # of what is imported nothing becomes garbage; `worker` enables it
    from workbench.jobs.process.worker import main as work  # here: numpy and all it takes are not the keeper's

    work(messages)


def _watch(worker: int, life: int, wake: int) -> int | None:
    """Return the wait status of `worker` once it has ended, or None where it is to be ended."""
    while True:
        while True:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == worker:
                return status
            if pid == 0:
                break
        ready, _, _ = select.select([life, wake], [], [])
        if life in ready:
            return None
        os.read(wake, 1 << 12)


def _end_all(worker: int) -> None:
    """Kill the worker's group and then every process that is or becomes a child, until none is left."""
    _kill(-worker)
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        from workbench.jobs.process.processes import kill, own_children  # here: most runs leave nothing behind

        kill(own_children())
        time.sleep(PAUSE)


def _end_like(status: int | None) -> None:
    """End with the exit code or by the signal of `status`; by SIGKILL where there is none."""
    code = -signal.SIGKILL if status is None else os.waitstatus_to_exitcode(status)
    if code < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if -code not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code)


def _kill(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, signal.SIGKILL)


if __name__ == "__main__":
    main()
