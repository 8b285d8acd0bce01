"""A function after every N steps: bits on several ranks and resumed; failures end all ranks."""

import math
import random
import re
import shutil
import threading

import each_probe
import numpy as np
import pytest
from processes import PROGRAMS
from run_files import digests, go_back

import pgimp
from pgimp.errors import CaseError, DamagedError, RunError, UsageError
from pgimp.solver.callbacks.exact_sum import parts_of, rounded
from pgimp.solver.callbacks.exchange import Exchange
from pgimp.solver.callbacks.memory import decoded, encoded

PROBE = PROGRAMS / "each_probe.py"


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A run with a controller on one rank."""
    folder = tmp_path_factory.mktemp("each")
    return pgimp.run(each_probe.CASE, output=folder / "1", each=each_probe.each(), quiet=True)


def test_the_load_is_what_was_set(alone):
    """The momentum changes by the mass times gravity, which the rule gives once more."""
    seen = []

    def look(now):
        seen.append((now.time, now.loads["push"], dict(now.state)))
        each_probe.control(now)

    state = each_probe.each().state
    sim = pgimp.Simulation(each_probe.CASE, each=pgimp.Each(look, 4, state))
    before = sim.diagnostics()
    sim.step(40)
    assert [round(t, 12) for t, *_ in seen] == [0.04 * k for k in range(1, 11)]
    assert seen[0][1] == 0.5 and len({push for _, push, _ in seen}) == 10
    gained = sim.diagnostics()["momentum-x"] - before["momentum-x"]
    assert gained == pytest.approx(18.0 * 0.04 * sum(push for _, push, _ in seen), rel=1e-12)
    assert seen[-1][2]["calls"] == 9
    assert seen[-1][2]["mass"] == pytest.approx(18.0, rel=1e-14)
    np.testing.assert_allclose(seen[-1][2]["far"], [8.75, 1.25], atol=0.5)
    assert state["calls"] == 0  # that of another simulation begins anew


def test_bits_do_not_depend_on_ranks_nor_on_a_kill(alone, mpirun):
    done = mpirun(3, [PROBE, alone.path.with_name("3")], 300)
    assert done.returncode == 0, done.stderr
    assert digests(alone.path.with_name("3")) == digests(alone.path)
    shutil.copytree(alone.path, resumed := alone.path.with_name("2"))
    go_back(resumed, 0.5)
    with pytest.raises(UsageError, match=r"with a function after its steps .*: give it again"):
        pgimp.run(each_probe.CASE, output=resumed, resume=True, quiet=True)
    done = mpirun(2, [PROBE, resumed, "resume"], 300)
    assert done.returncode == 0, done.stderr
    assert pgimp.open(resumed).info["resumed_from"] > 40
    assert (resumed / "history.csv").read_text() == (alone.path / "history.csv").read_text()
    assert digests(resumed) == digests(alone.path)


@pytest.mark.parametrize(
    ("way", "text"),
    [
        ("fail", r"control after step 20 fails on rank 1: ZeroDivisionError: the controller is at "
         r"its end \(.*each_probe.py:\d+\)"),
        ("local", r"control after step \d+: its state, .* is another one on rank 1 than on rank 0"),
    ],
)  # fmt: skip
def test_a_failure_on_one_rank_ends_all_with_one_message(way, text, mpirun, tmp_path):
    done = mpirun(2, [PROBE, tmp_path / "run", way], 120)
    assert done.returncode != 0
    assert re.search(text, done.stderr.replace("\n", " ")), done.stderr
    assert done.stderr.count("pgimp: ") == 1 and "Traceback" not in done.stderr


def test_what_is_wrong_is_refused():
    with pytest.raises(UsageError, match="expected a number of steps from 1 on, got 0"):
        pgimp.Each(print, 0)
    with pytest.raises(UsageError, match="expected a function, got 3"):
        pgimp.Simulation(each_probe.CASE, each=3)
    with pytest.raises(UsageError, match="the state 'x' is a list; it may have numbers, texts"):
        pgimp.Each(print, state={"x": []})
    for wrong, text in {
        "unknown": r"KeyError: .*unknown controlled load 'unknown'.* known: push",
        "push": "ValueError: the load 'push' was set to nan",
    }.items():

        def set_wrongly(now, wrong=wrong):
            now.loads[wrong] = math.nan if wrong == "push" else 1.0

        sim = pgimp.Simulation(each_probe.CASE, each=set_wrongly)
        with pytest.raises(RunError, match=f"set_wrongly after step 1 fails here: {text}"):
            sim.step()
    with pytest.raises(CaseError, match=r"gravity\.0"):
        pgimp.load(each_probe.CASE | {"gravity": [{"control": 3}, 0.0]})


def test_sums_are_those_of_fsum_in_any_order():
    rng = random.Random(1)
    values = [rng.uniform(-1, 1) * 2.0 ** rng.randint(-1070, 900) for _ in range(3000)]
    values += [-values[5], 5e-324, -0.0, 1e308]
    expected = math.fsum(values)
    for count in (1, 2, 7):
        rng.shuffle(values)
        parts = [parts_of(np.array(values[k::count])) for k in range(count)]
        assert rounded(parts) == expected
    assert rounded([parts_of(np.array([]))]) == 0.0
    assert rounded([parts_of(np.array([1e308] * 2))] * 9) == math.inf


def test_ranks_that_do_other_things_all_hear_of_it():
    barrier, slots = threading.Barrier(3), [None] * 3

    class Comm:
        size = 3

        def __init__(self, rank):
            self.rank = rank

        def allgather(self, value):
            slots[self.rank] = value
            barrier.wait(20)
            every = list(slots)
            barrier.wait(20)
            return every

    def work(rank, acts, found):
        exchange = Exchange(Comm(rank), "each: f after step 3")
        try:
            for act in acts:
                exchange.gather(act, rank)
            found[rank] = "done"
        except RunError as error:
            found[rank] = str(exchange.fail("again"))
            assert found[rank] == str(error)

    for acts, text in {
        (("a sum", "its end"),) * 3: "done",
        (("a sum", "its end"), ("its end",), ("a sum", "its end")): "each: f after step 3: its "
        "act 1 is a sum on rank 0, but its end on rank 1; sums and the like are for all ranks "
        "together",
    }.items():
        found = [""] * 3
        threads = [
            threading.Thread(target=work, args=(k, acts[k], found), daemon=True) for k in range(3)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
        assert found == [text] * 3


def test_a_state_is_kept_bit_for_bit():
    state = {"a": 0.1, "n": 7, "t": "x", "f": False, "no": None, "nan": math.nan,
             "m": np.array([[1.0, np.inf]]), "i": np.arange(3)}  # fmt: skip
    back = decoded(encoded(state, "here"))
    assert [*back] == [*state]
    for name, value in state.items():
        np.testing.assert_array_equal(back[name], value)
        assert type(back[name]) is type(value)
    with pytest.raises(DamagedError, match=r"its state of the program is not what it must be"):
        decoded({"a": {"number": "far"}})
    with pytest.raises(RunError, match=r"bytes, of at most 1,048,576"):
        encoded({"a": np.zeros(1 << 18)}, "here")


@pytest.mark.parametrize("change", [{}, {"gravity": [{"control": "push", "start": 0.5}, 0.0]}])
def test_a_load_that_is_set_holds_in_the_next_stage(change):
    """Also where the stage names it again."""
    stages = [{"name": "second", "end": 0.4, **change}]
    case = pgimp.load(each_probe.CASE, {"time.end": 0.2, "time.stages": stages})
    sim = pgimp.Simulation(case, each=pgimp.Each(lambda now: now.loads.update(push=3.0), 4))
    before = sim.diagnostics()["momentum-x"]
    sim.advance()
    first, mass = 4 * 0.01, sim.particles["mass"].sum()
    gained = sim.diagnostics()["momentum-x"] - before
    assert gained == pytest.approx(mass * (0.5 * first + 3.0 * (0.4 - first)), rel=1e-12)


def test_a_resumed_state_has_the_types_of_one_that_went_on(tmp_path):
    """Numbers of other precisions, and arrays in other orders, would add up otherwise."""
    fields = np.asfortranarray(np.random.default_rng(1).normal(size=(300, 30)))
    state = {"sum": np.float32(0.1), "fields": fields}

    def add(now):
        assert type(now.state["sum"]) is float
        assert now.state["fields"].flags.c_contiguous
        now.state["sum"] = np.float32(0.1) + np.float32(now.state["sum"])
        now.state["fields"] = np.asfortranarray(1.1 * now.state["fields"])

    sim = pgimp.Simulation(each_probe.CASE, each=pgimp.Each(add, 1, state))
    sim.step(3)
    assert state["fields"] is fields and state["sum"] == np.float32(0.1)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda now: setattr(now, "state", {}), r"now.state cannot be replaced; set what is in"),
        (lambda now: setattr(now, "loads", {}), r"now.loads cannot be replaced; set what is in"),
        (lambda now: now.sum(np.ones((2, 2, 2))), r"a table, got an array of 3 dimensions"),
        (lambda now: now.state.update(n=10**30), r"'n' is an integer of more than 64 bits"),
    ],
)  # fmt: skip
def test_what_would_be_lost_is_refused(wrong, text):
    sim = pgimp.Simulation(each_probe.CASE, each=wrong)
    with pytest.raises(RunError, match=text):
        sim.step()
    with pytest.raises(UsageError, match=r"expected a state, values by name, got 5"):
        pgimp.Each(wrong, state=5)


def test_a_file_in_a_folder_called_pgimp_is_not_of_the_package(tmp_path):
    """The place of an error is the line of the user's file, not one of a library that it calls."""
    source = "import json\n\ndef control(now):\n    json.loads('{')\n"
    names = {}
    exec(compile(source, str(tmp_path / "pgimp" / "control.py"), "exec"), names)
    sim = pgimp.Simulation(each_probe.CASE, each=names["control"])
    with pytest.raises(RunError, match=r"JSONDecodeError: .* \(.*/pgimp/control\.py:4\)"):
        sim.step()


def test_the_level_of_water_may_be_controlled():
    water = {"level": {"control": "table", "start": 1.0}, "density": 0.1}
    case = pgimp.load(each_probe.CASE | {"gravity": [0.0, -1.0], "water": water})

    def lower(now):
        now.loads["table"] = 0.9

    sim = pgimp.Simulation(case, each=lower)
    sim.step()
    assert sim.core.case.water.height(sim.time) == 0.9
    assert case.water.height(0.0) == 1.0  # of no other simulation
