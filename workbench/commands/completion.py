"""`workbench completion`: what the shell needs to complete commands, options and their values."""

from __future__ import annotations

from pathlib import Path

import click
from click.shell_completion import get_completion_class

from instances.disk import write_aside
from workbench.options import JSON
from workbench.terminal import print_json, say

PLACES = {
    "bash": ".local/share/bash-completion/completions/workbench",
    "zsh": ".local/share/zsh/site-functions/_workbench",
    "fish": ".config/fish/completions/workbench.fish",
}
"""Shell → where it looks for a user's completions, below the home folder."""


@click.command("completion")
@click.argument("shell", type=click.Choice(list(PLACES)))
@click.option("--install", is_flag=True, help="Write it where the shell looks for it.")
@JSON
def command(shell: str, install: bool, as_json: bool) -> None:
    """Print what SHELL needs to complete commands, options, and names of solvers, families and methods.

    \b
    Examples:
      workbench completion bash --install     for new shells
      source <(workbench completion bash)     for this shell, now
    """
    from workbench.cli import commands

    made = get_completion_class(shell)
    assert made is not None
    source = made(commands, {}, "workbench", "_WORKBENCH_COMPLETE").source()
    target = Path.home() / PLACES[shell] if install else None
    if target:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_aside(target, source + "\n")
    if as_json:
        print_json({"shell": shell, "file": target, "script": source})
        return
    if target is None:
        click.echo(source)
        return
    say(f"{target}: new {shell} shells complete workbench")
    if shell == "zsh":
        say(f"(where {target.parent} is on fpath before compinit)")
