"""The proofs of scripts/faults, in short: they hold, and print their figures."""

import re
import sys
from pathlib import Path

import pytest
from conftest import run

PROOFS = Path(__file__).resolve().parents[1] / "scripts" / "proofs"


def prove(*words, timeout=600):
    job = run([sys.executable, str(PROOFS), *words], timeout)
    assert job.returncode == 0, job.stdout + job.stderr
    return job.stdout


def test_killed_runs_go_on_to_the_same_bits():
    said = prove("kill", "--short", "--runs", "6", "--seed", "3")
    assert "same bits as the undisturbed run: 6 of 6" in said
    assert re.search(r"killed: .*start-up", said) and re.search(r"killed: .*checkpoint", said)
    # mpirun gives the other ranks two seconds, and it is alone on no machine.
    assert float(re.search(r"end of the job: .* most ([\d.]+) s", said)[1]) < 15.0


def test_runs_stop_on_every_signal_and_go_on_to_the_same_bits():
    said = prove("signals", "--short", "--runs", "6", "--seed", "2")
    same = re.findall(r"(\d+) (status \d+)[^,]*(?:, within[^,]*)?, same bits", said)
    assert sum(int(count) for count, _ in same) == 6, said
    assert sum(int(count) for count, what in same if what == "status 75") >= 3, said


def test_damaged_checkpoints_are_skipped_or_refused():
    said = prove("checkpoints", "--runs", "56")
    assert "42 newest damaged: skipped, same bits, 14 all damaged: status 1" in said


def test_many_steps_leave_no_trace_in_the_memory():
    said = prove("long", "--quick")
    assert said.count("mass: 1 value(s)") == 2
    for residual in re.findall(r"is at most ([\d.e+-]+) of", said):
        assert float(residual) < 1e-8  # rounding of as many steps


@pytest.mark.parametrize("words", [["nothing"], ["kill", "--runs", "many"]])
def test_wrong_words_are_answered(words):
    job = run([sys.executable, str(PROOFS), *words])
    assert job.returncode != 0 and "Traceback" not in job.stderr
