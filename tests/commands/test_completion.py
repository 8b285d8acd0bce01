"""``pgimp completion``: the shells themselves are asked for completions, by the script they get."""

import shutil

import pytest
from shells import completions

from pgimp.cli import main, parser_of
from pgimp.commands import COMMANDS
from pgimp.commands.init import packaged
from pgimp.utilities.element.paths import PATHS

SHELLS = ("bash", "zsh")
FOLDERS = {"block.out", "results", "sweep.study.out"}
#: Lines, and what the word at their end may be.
LINES = {
    "pgimp ": {*COMMANDS, "case.yaml", "old.yml", "my case.yaml", *FOLDERS},
    "pgimp co": {"compare", "completion"},
    "pgimp init ": {*packaged()},
    "pgimp init dam": {"dam-break"},
    "pgimp check c": {"case.yaml"},
    "pgimp study ": {"case.yaml", "old.yml", "my case.yaml", *FOLDERS},
    "pgimp plot ": FOLDERS,
    "pgimp plot block.out --field von": {"von-mises"},
    "pgimp plot block.out r": {"results"},
    "pgimp plot results/": {"results/inner.out"},
    "pgimp compare block.out ": FOLDERS,
    "pgimp report ": FOLDERS,
    "pgimp export ": {"csv", "vtkhdf", "vtu"},
    "pgimp export csv ": FOLDERS,
    "pgimp element case.yaml rubber --path ": {*PATHS},
    "pgimp batch case.yaml --wall-time 2:00:00 --scheduler ": {"pbs", "slurm"},
    "pgimp batch --ranks 8 c": {"case.yaml"},
    "pgimp batch case.yaml --ranks ": set(),
    "pgimp case.yaml --set grid.cell=[0.5] --import ": {"own.py", *FOLDERS},
    "pgimp case.yaml --import own.py --import o": {"own.py"},
    "pgimp case.yaml --over": {"--overwrite"},
    "pgimp completion ": {*SHELLS},
}
#: What shtab's script does not complete in zsh: an option's value after a case, and a place that
#: may be repeated, from its second word on.
BEYOND = {
    "bash": (),
    "zsh": (
        "pgimp plot block.out r",
        "pgimp case.yaml --set grid.cell=[0.5] --import ",
        "pgimp case.yaml --import own.py --import o",
    ),
}


@pytest.fixture
def folder(tmp_path):
    """Cases, runs and a study, and what is none."""
    home = tmp_path / "folder"
    for name in ("block.out/run.json", "results/inner.out/run.json", "sweep.study.out/study.csv"):
        (home / name).parent.mkdir(parents=True)
        (home / name).touch()
    for name in ("case.yaml", "old.yml", "my case.yaml", "own.py", "notes.txt"):
        (home / name).touch()
    return home


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_completes(shell, folder, tmp_path, capsys):
    assert shutil.which(shell), f"{shell} is missing: scripts/setup --test installs it"
    assert main(["completion", shell]) == 0
    script = tmp_path / f"pgimp.{shell}"
    script.write_text(capsys.readouterr().out)
    lines = {line: words for line, words in LINES.items() if line not in BEYOND[shell]}
    assert completions(shell, script, lines, folder) == lines


@pytest.mark.parametrize("shell", SHELLS)
def test_every_option_is_known(shell, capsys):
    """Each name of the parsers is in the script: what is added to a command comes by itself."""
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for name in ("run", *COMMANDS):
        for action in parser_of(name)._actions:
            for option in action.option_strings:
                assert option in script


def test_another_shell(capsys):
    assert main(["completion", "tcsh"]) == 2
    assert "invalid choice: 'tcsh'" in capsys.readouterr().err
