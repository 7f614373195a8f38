"""Solvers that start, stop, hide and end processes, or end their own in some way."""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import os
import resource
import shutil
import signal
import sys
import threading
import time
from pathlib import Path

from tests.faults.hostile import Honest, honest, plug_in

FOREVER = 31415
"""Seconds of sleep by which a process that has hidden its environment is recognised."""


def orphan(act):
    """Run `act` in a process that has a session of its own and a parent that has ended."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            act()
        os._exit(0)


def spin():
    while True:
        pass


@plug_in
def leaves_a_session(instance, observe):
    if os.fork() == 0:
        os.setsid()
        time.sleep(FOREVER)


@plug_in
def leaves_a_daemon(instance, observe):
    orphan(lambda: time.sleep(FOREVER))


@plug_in
def leaves_a_spinner(instance, observe):
    orphan(spin)


@plug_in
def leaves_a_deaf_daemon(instance, observe):
    def deaf():
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        time.sleep(FOREVER)

    orphan(deaf)


@plug_in
def leaves_what_has_forgotten_us(instance, observe):
    """A daemon that is another program, with an empty environment and no file open."""
    orphan(lambda: (os.closerange(0, 64), os.execve("/bin/sleep", ["sleep", str(FOREVER)], {})))


def hand_over(seconds=1.0):
    """Hand over to another process every few milliseconds, then sleep."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if os.getpid() != os.getsid(0):
            os.setsid()
        time.sleep(0.005)
        if os.fork():
            os._exit(0)
    time.sleep(FOREVER)


@plug_in
def leaves_a_chain(instance, observe):
    orphan(hand_over)


@plug_in
def forks_fifty(instance, observe):
    for _ in range(50):
        if os.fork() == 0:
            os.setsid()
            time.sleep(FOREVER)


@plug_in
def forks_fifty_that_fork(instance, observe):
    for _ in range(25):
        orphan(lambda: (os.fork(), time.sleep(FOREVER)))
    spin()


@plug_in
def sleeps(instance, observe):
    time.sleep(FOREVER)


@plug_in
def sleeps_deafly(instance, observe):
    for number in range(1, 32):
        with contextlib.suppress(OSError):
            signal.signal(number, signal.SIG_IGN)
    while True:
        time.sleep(FOREVER)


@plug_in
def stops_itself(instance, observe):
    os.kill(os.getpid(), signal.SIGSTOP)


@plug_in
def stops_its_parent(instance, observe):
    os.kill(os.getppid(), signal.SIGSTOP)


@plug_in
def stops_its_parent_and_sleeps(instance, observe):
    os.kill(os.getppid(), signal.SIGSTOP)
    time.sleep(FOREVER)


@plug_in
def kills_its_group(instance, observe):
    os.killpg(0, signal.SIGKILL)


@plug_in
def kills_its_parent(instance, observe):
    orphan(lambda: time.sleep(FOREVER))
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(FOREVER)


@plug_in
def kills_its_parent_amid_forks(instance, observe):
    """Whoever looks once for what is left misses the next in the chain."""
    for _ in range(5):
        orphan(hand_over)
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(FOREVER)


@plug_in
def kills_its_parent_unseen(instance, observe):
    """Without the parent, nothing but the kernel knows a process that has another program and no environment."""
    orphan(lambda: (os.closerange(0, 64), os.execve("/bin/sleep", ["sleep", str(FOREVER)], {})))
    time.sleep(0.2)
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(FOREVER)


@plug_in
def guarded_by_a_killer(instance, observe):
    """Another process kills the parent as soon as this one has ended, before that has looked for what is left."""
    ours, parent = os.getpid(), os.getppid()

    def guard():
        while Path(f"/proc/{ours}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX":
            time.sleep(0.001)
        os.kill(parent, signal.SIGKILL)
        time.sleep(FOREVER)

    orphan(guard)
    time.sleep(FOREVER)


@plug_in
def kills_itself(instance, observe):
    os.kill(os.getpid(), signal.SIGKILL)


@plug_in
def terminates_itself(instance, observe):
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGTERM)


@plug_in
def outlives_its_parent(instance, observe):
    ctypes.CDLL(None).prctl(1, 0)  # PR_SET_PDEATHSIG: not killed with the keeper
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(FOREVER)


@plug_in
def adopts(instance, observe):
    ctypes.CDLL(None).prctl(36, 1)  # PR_SET_CHILD_SUBREAPER: orphans come to us instead
    orphan(lambda: time.sleep(FOREVER))
    time.sleep(FOREVER)


@plug_in
def closes_everything(instance, observe):
    os.closerange(0, 1024)


@plug_in
def closes_its_streams(instance, observe):
    sys.stdin.close()
    sys.stdout.close()
    os.closerange(0, 3)


@plug_in
def exits_quietly(instance, observe):
    os._exit(0)


@plug_in
def exits(instance, observe):
    sys.exit(0)


@plug_in
def aborts(instance, observe):
    os.abort()


@plug_in
def segfaults(instance, observe):
    ctypes.string_at(0)


@plug_in
def becomes_another_program(instance, observe):
    os.execv("/bin/true", ["true"])


@plug_in
def leaves_a_thread(instance, observe):
    threading.Thread(target=time.sleep, args=(FOREVER,)).start()


@plug_in
def sleeps_at_exit(instance, observe):
    atexit.register(time.sleep, FOREVER)


@plug_in
def recurses(instance, observe):
    sys.setrecursionlimit(10**9)

    def again(n):
        return again(n + 1) + again(n + 2)

    again(0)


@plug_in
def dumps(instance, observe):
    resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))


@plug_in
def loses_its_folder(instance, observe):
    here = Path("lost").absolute()
    here.mkdir(exist_ok=True)
    os.chdir(here)
    shutil.rmtree(here)


@plug_in
def goes_elsewhere(instance, observe):
    os.chdir("/")
    os.umask(0o777)


@plug_in
def prints_gigabytes(instance, observe):
    block = b"no end of it " * 5000
    while True:
        os.write(1, block)


@plug_in
def turns_clocks_back(instance, observe):
    time.perf_counter = time.monotonic = time.time = lambda: -5000.0
    time.sleep(0.1)


class SpinsWhilePreparing(Honest):
    def prepare(self, instance):
        spin()


class SleepsWhilePreparing(Honest):
    def prepare(self, instance):
        time.sleep(FOREVER)


class SolvesWhilePreparing(Honest):
    """Takes its time where it is not timed."""

    def prepare(self, instance):
        until = time.process_time() + 3
        while time.process_time() < until:
            pass


class ForksWhilePreparing(Honest):
    """Spins in processes of its own, where its own processor time does not show it."""

    def prepare(self, instance):
        orphan(spin)
        orphan(spin)
        time.sleep(FOREVER)


@plug_in
def eats_memory(instance, observe):
    eaten = []
    while True:
        eaten.append(os.urandom(20_000_000))
        time.sleep(0.01)


@plug_in
def orphan_eats_memory(instance, observe):
    def eat():
        eaten = []
        while True:
            eaten.append(os.urandom(20_000_000))
            time.sleep(0.01)

    orphan(eat)
    time.sleep(FOREVER)


@plug_in
def four_hold_memory(instance, observe):
    """Each less than the limit, together more."""

    def hold():
        held = os.urandom(200_000_000)
        time.sleep(FOREVER + len(held) * 0)

    for _ in range(4):
        orphan(hold)
    time.sleep(FOREVER)


@plug_in
def lies_afterwards(instance, observe):
    """Leaves a process that goes on talking for it after its end."""
    result = honest(instance, observe)

    def talk():
        while True:
            observe_again()

    def observe_again():
        honest(instance, observe)

    orphan(talk)
    return result
