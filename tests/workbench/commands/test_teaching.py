"""Commands that teach: templates that run, lists, completion with values."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import click
import pytest
from click.testing import CliRunner

from instances.compilation import WORDS, OnStderr, told_to
from workbench.cli import COMMANDS, commands


def completed(words: str, at: int) -> list[str]:
    """Return what the shell is offered for the word `at` of a command line."""
    environment = {"COMP_WORDS": words, "COMP_CWORD": str(at), "_WORKBENCH_COMPLETE": "bash_complete"}
    code = "from workbench.cli import main; import sys; sys.argv[0] = 'workbench'; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | environment, capture_output=True, text=True, check=False
    )
    return [line.partition(",")[2] for line in done.stdout.splitlines()]


def offered(command: str, parameter: str, incomplete: str) -> list[str]:
    """Return what a parameter's completion offers, without a shell."""
    found = commands.get_command(None, command)  # type: ignore[arg-type]
    each = next(p for p in found.params if p.name == parameter)
    return [item.value for item in each.shell_complete(click.Context(found, info_name=command), incomplete)]


def test_the_shell_completes_commands_and_values() -> None:
    assert "solve" in completed("workbench so", 1)
    assert completed("workbench solve --solver mem", 3) == ["memetic"]


@pytest.mark.parametrize(
    ("command", "parameter", "incomplete", "value"),
    [
        ("generate", "family", "wind-", "wind-vortices"),
        ("compare", "targets", "qu", "quick"),
        ("compare", "solvers", "ga,mem", "ga,memetic"),
        ("place", "method", "gr", "greedy-swap"),
        ("costs", "method", "", "refined"),
        ("mission", "stage", "ro", "routes"),
        ("warmup", "names", "ref", "refined"),
        ("report", "columns", "gap_found,ti", "gap_found,time"),
        ("place", "columns", "mean", "mean_sd"),
    ],
)
def test_values_are_offered(command: str, parameter: str, incomplete: str, value: str) -> None:
    assert value in offered(command, parameter, incomplete)


def test_completion_is_installed_for_the_user(cli, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cli("completion", "bash", "--install")[0] == 0
    kept = tmp_path / ".local/share/bash-completion/completions/workbench"
    assert "_WORKBENCH_COMPLETE" in kept.read_text()


def test_the_template_of_a_study_runs(cli, tmp_path):
    assert cli("init", "study", "mine.toml")[0] == 0
    code, out, _ = cli("compare", "mine.toml", "--dry-run", "--out", "runs")
    assert code == 0
    assert "16 runs to do" in out


def test_the_template_of_a_scenario_runs(cli, tmp_path):
    assert cli("init", "scenario", "wind.toml")[0] == 0
    assert cli("costs", "wind.toml", "--out", "wind.json")[0] == 0
    assert json.loads(cli("solve", "wind.json", "--solver", "subset-dp", "--json")[1])["status"] == "OPTIMAL"


def test_the_template_of_a_solver_runs(cli, instance_file, tmp_path, monkeypatch):
    assert cli("init", "solver", "own.py")[0] == 0
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    found = json.loads(cli("solve", instance_file, "--solver", "own:NearestFirst", "--json")[1])
    assert found["status"] == "FEASIBLE"


def test_a_template_overwrites_nothing(cli, tmp_path):
    (tmp_path / "mine.toml").write_text("kept")
    code, _, err = cli("init", "study", "mine.toml")
    assert code == 2
    assert "is not overwritten" in err
    assert (tmp_path / "mine.toml").read_text() == "kept"
    assert cli("init", "solver", "not-a-module.py")[0] == 2
    assert cli("init", "study", "mine.py")[0] == 2


def test_lists_are_there_for_people_and_programs(cli):
    for name in ("studies", "methods", "solvers", "families"):
        assert json.loads(cli(name, "--json")[1])
        assert cli(name)[0] == 0


def test_warmup_says_what_is_ready(cli):
    code, out, _ = cli("warmup", "greedy", "map")
    assert code == 0
    assert out.startswith("greedy, map: ready after")


def test_warmup_names_what_it_cannot_warm(cli):
    code, _, err = cli("warmup", "memetik")
    assert code == 2
    assert "'memetik' is no solver" in err
    assert "memetic" in err


def test_a_cold_start_is_told_and_a_warm_one_is_not(cli, instance_file, tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "machine-code"))  # which the child of the run inherits
    said = []
    for _ in range(2):
        with told_to(OnStderr()):
            code, _, err = cli("solve", instance_file, "--solver", "subset-dp")
        assert code == 0
        said.append(err.count(WORDS))
    assert said == [1, 0]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_help_with_examples_that_can_be_typed(name) -> None:
    shown = CliRunner().invoke(commands, [name, "--help"])
    assert shown.exit_code == 0
    assert max(map(len, shown.output.splitlines())) <= 80
    examples = re.findall(r"^ +workbench (\S+)(.*?)(?:   .*)?$", shown.output.partition("Examples:")[2], re.MULTILINE)
    assert name in [command for command, _ in examples]
    for command, words in examples:
        found = commands.get_command(None, command)  # type: ignore[arg-type]
        found.make_context(command, shlex.split(words))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_speaks_json(name) -> None:
    found = commands.get_command(None, name)  # type: ignore[arg-type]
    flags = [option for parameter in found.params for option in parameter.opts]
    assert "--json" in flags


BASH = shutil.which("bash")


@pytest.mark.skipif(BASH is None, reason="there is no bash here")
def test_bash_completes_with_the_script_that_is_printed(cli, tmp_path, monkeypatch):
    program = tmp_path / "bin" / "workbench"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nfrom workbench.cli import main\nmain()\n")
    program.chmod(0o755)
    (tmp_path / "script").write_text(cli("completion", "bash")[1])
    asked = ["sol", "solve a.json --solver mem", "generate wind-vo", "compare abla", "place --method nl"]
    lines = ["source ./script", "compopt() { :; }"]  # which only readline may call
    for words in asked:
        lines.append(f"COMP_WORDS=(workbench {words}); COMP_CWORD={len(words.split())}; COMPREPLY=()")
        lines.append('_workbench_completion workbench; echo "${COMPREPLY[*]}"')
    environment = os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}"}
    done = subprocess.run([BASH, "-c", "\n".join(lines)], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["solve solvers", "memetic", "wind-vortices", "ablation", "nlp"]
