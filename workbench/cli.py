"""The command line: `workbench COMMAND`. Each command is imported only when it is called.

Exit codes: 0 fine, 1 a problem was found, 2 unusable input, 130 interrupted (143 by SIGTERM, 129 by SIGHUP).
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from typing import NoReturn

import click

from workbench.threads import keep_to_one

COMMANDS = {
    "generate": "make instances of a family",
    "solve": "solve one instance",
    "check": "verify routes, or every run of a store, independently",
    "compare": "run solvers on instances and report",
    "report": "make pages and tables from stored runs",
    "paper": "write tables, figures and references for LaTeX",
    "convert": "translate between file formats",
    "select": "choose the tasks worth flying within endurance",
    "place": "choose task locations of most information",
    "costs": "compute moving costs of a scenario in wind",
    "bound": "print lower bounds of an instance",
    "certify": "prove a bound and write the proof",
    "mission": "run the paper's whole chain",
    "figures": "draw the paper's Figs. 1 and 2",
    "import": "take results of other programs into a store",
    "record": "keep a record book of best known values",
    "status": "say how far a study has got",
    "watch": "serve a local page of a study as it runs",
    "solvers": "list solvers and their options",
    "families": "list instance families and their parameters",
    "methods": "list methods of placement and moving costs",
    "studies": "list the studies that come along",
    "init": "write a commented template that runs",
    "schema": "print the JSON Schema of a file format",
    "warmup": "compile the kernels now",
    "completion": "complete commands and values in a shell",
}
"""Command → one line of help; the command itself is ``workbench.commands.<name>:command``."""

NO_FAULT_OF_OURS = (errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE, errno.ENAMETOOLONG)
"""Errors that say all there is to say: a full disk, no more files, a name longer than the system's."""


class LazyCommands(click.Group):
    """A group that knows its commands' names and imports each only when asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in their natural order."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f"workbench.commands.{cmd_name}").command
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse, for every command, what no file, name or number can be: bytes that are not text."""
        for arg in args:
            if "\0" in arg or any("\ud800" <= sign <= "\udfff" for sign in arg):
                from instances.errors import InputError, shown

                raise InputError(f"{shown(arg)}: is not UTF-8 text")
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Suggest the near miss of an unknown command."""
        if args and not args[0].startswith("-") and args[0] not in COMMANDS:
            from instances.errors import suggestion

            ctx.fail(f"unknown command '{args[0]}'{suggestion(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing one."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyCommands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="mmmdmtsp-workbench")
def commands() -> None:
    """Plan tours for several UAVs in wind, and compare the solvers that do it."""


@contextlib.contextmanager
def signals_as_exits() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end what runs as Ctrl-C does, children included; where ignored (nohup) they stay so."""

    def leave(number: int, frame: object) -> NoReturn:
        sys.exit(128 + number)

    numbers = (signal.SIGTERM, signal.SIGHUP) if threading.current_thread() is threading.main_thread() else ()
    taken = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, leave)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def main(args: list[str] | None = None) -> NoReturn:
    """Run the command line and exit; an InputError becomes one sentence on stderr and exit code 2.

    So does what the machine refuses, for want of memory or room; every other exception is a fault of ours and is shown
    whole.
    """
    keep_to_one()
    try:
        with signals_as_exits():
            # click's own standalone mode would turn Ctrl-C into exit code 1
            code = commands.main(args=args, prog_name="workbench", standalone_mode=False)
    except click.ClickException as error:
        from instances.errors import InputError  # here, not above: --help must not import numpy

        error.message = str(InputError(error.message))  # type: ignore[misc]  # one line, however long the value
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        sys.exit(130)
    except BrokenPipeError:  # the reader of our output, such as head, has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except MemoryError:
        click.echo("workbench: needs more memory than this machine gives it", err=True)
        sys.exit(1)
    except OSError as error:
        if error.errno not in NO_FAULT_OF_OURS:
            raise
        from instances.errors import shown

        where = f"{shown(error.filename)}: " if error.filename else ""
        click.echo(f"workbench: {where}{error.strerror}", err=True)
        sys.exit(2)
    except ValueError as error:
        from instances.errors import InputError  # here, not above: --help must not import numpy

        if not isinstance(error, InputError):
            raise
        from workbench.terminal import say

        say(f"workbench: {error}", err=True)
        sys.exit(2)
    sys.exit(code if isinstance(code, int) else 0)
