"""The parts of a study, its file and its runs, each against something independent."""

import re
from itertools import product

import numpy as np
import pytest
from falling_study import put
from hypothesis import given
from hypothesis import strategies as st
from mentioned import mentions
from schema_checker import Checker
from study_files import HEAD, SWEEP

from pgimp.case.reader import dump_case, read_case
from pgimp.errors import CaseError, UsageError
from pgimp.schema.document import parse
from pgimp.utilities.reference.jsonschema import study_schema
from pgimp.utilities.study.accuracy import study_of
from pgimp.utilities.study.plan import read_plan
from pgimp.utilities.study.runs import last_words
from pgimp.utilities.study.schema import Study
from pgimp.utilities.study.sweep import variants


def made(*sweep, **more):
    """The runs of a sweep, each as its name and its changes by key."""
    study = Study.model_validate(
        {"format": 1, "case": "c.yaml", "error": "error", "sweep": list(sweep), **more}
    )
    return {one.name: {c.key: c.value for c in one.changes} for one in variants(study)}


def test_entries_are_combined_and_the_keys_of_one_go_together():
    shapes, cells, sizes = ["gimp", "mpm"], [[2.0], [0.5]], [[54.0], [50.5]]
    found = made(
        {"method.shape": shapes}, {"grid.cell": cells, "grid.size": sizes}, set={"time.end": 3}
    )
    expected = [
        {"time.end": 3, "method.shape": shape, "grid.cell": cell, "grid.size": size}
        for shape, (cell, size) in product(shapes, zip(cells, sizes, strict=True))
    ]
    assert list(found.values()) == expected
    assert list(found) == ["gimp_cell-2", "gimp_cell-0.5", "mpm_cell-2", "mpm_cell-0.5"]


def test_names_are_given_or_tell_the_runs_apart_by_little():
    whole = {"shape": "gimp", "particles-per-cell": [2], "volume": "tracked"}
    fuzzy = [
        {"shape": "fuzzy-nearest", "size": "fixed", "wall": "mirror"},
        {"shape": "fuzzy-nearest", "size": "tracked", "wall": "mirror"},
    ]
    assert list(made({"Our own, at 50 %!": {"method": whole}, "b": {}})) == ["Our-own-at-50", "b"]
    assert list(made({"method": fuzzy})) == ["fixed", "tracked"]
    assert list(made({"method": [whole, fuzzy[0]]})) == ["gimp", "fuzzy-nearest"]
    assert list(made({"a": [1, 1], "b": [1, 2]})) == ["b-1", "b-2"]
    assert list(made({"a": [[1, 2], [2, 2]]})) == ["a-1x2", "a-2"]
    assert list(made({"a": [1, 1]})) == ["a-1-1", "a-1-2"]
    assert list(made({"a": ["x/y", "x:y", "..", "X y"]})) == ["x-y", "x-y-2", "run", "X-y-3"]
    assert list(made({"case": ["far/off/one.yaml", "two.yaml"]})) == ["one", "two"]


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=6,
)


@given(st.lists(st.lists(plain, min_size=1, max_size=4), min_size=1, max_size=3))
def test_every_run_has_a_name_of_its_own_that_a_folder_can_have(values):
    runs = list(made(*({f"k{i}": entry} for i, entry in enumerate(values))))
    assert len(runs) == np.prod([len(entry) for entry in values])
    assert len({name.casefold() for name in runs}) == len(runs)
    for name in runs:
        assert re.fullmatch(r"[A-Za-z0-9+][A-Za-z0-9.+_-]{0,110}", name)


def test_curves_are_what_is_swept_besides_x(tmp_path):
    text = HEAD + (
        "sweep:\n  - {fine: {grid.cell: [0.5]}, coarse: {grid.cell: [1.0]}}\n"
        "  - {method.volume: [tracked, initial]}\n  - {time.step: [0.1, 0.05]}\n"
    )

    def curves(plot):
        runs = read_plan(put(tmp_path, f"{text}plot: {{{plot}}}\n")).runs
        return {run.curve: None for run in runs}, {run.x for run in runs}

    both = dict.fromkeys(f"{v}, step {s}" for v in ("tracked", "initial") for s in (0.1, 0.05))
    assert curves("") == (both, {0.5, 1.0})
    assert curves("x: time.step")[0] == dict.fromkeys(
        f"{c}, {v}" for c in ("fine", "coarse") for v in ("tracked", "initial")
    )
    assert curves("group: method.volume")[0] == {"tracked": None, "initial": None}
    assert curves("group: [method.volume, grid.cell.0]")[0] == dict.fromkeys(
        f"{v}, 0 {c}" for c in (0.5, 1) for v in ("tracked", "initial")
    )


def test_the_case_that_is_checked_is_the_one_that_runs(tmp_path):
    """Read with the options of its command line, the case is the one that was checked."""
    text = HEAD + (
        "set: {output.every: null, bodies.bar.velocity: [-0.0], title: 'a=b, \"c\": [d] # e'}\n"
        "sweep:\n  - method: [{shape: mpm, particles-per-cell: [1]},\n"
        "             {shape: gimp, particles-per-cell: [3], volume: initial}]\n"
        "  - {gravity: [{table: [[0.0, [1.0e-7]], [1, [3]]]}, null]}\n"
    )
    runs = read_plan(put(tmp_path, text)).runs
    assert len(runs) == 4
    for run in runs:
        with open(run.file, "rb") as stream:
            assert dump_case(read_case(stream.read(), "c", run.options)) == run.resolved


WRONG = [
    (SWEEP.replace("sweep", "sweeps"), ":4: sweeps: unknown key; did you mean 'sweep'?"),
    ("sweep: []\n", ":4: sweep: expected at least 1 entry"),
    ("sweep: [{}]\n", ":4: sweep.0: expected a key with a list of values"),
    ("sweep: [{time.step: 0.1}]\n", ":4: sweep.0.time.step: expected a list, a value a run"),
    ("sweep: [{time.step: []}]\n", "expected at least one value"),
    ("sweep: [{a: [1, 2], b: [1]}]\n", "2 values of a and 1 here"),
    ("sweep: [{time.: [1]}]\n", "sweep.0.time.: expected keys joined by dots"),
    (f"{SWEEP}  - {{time: [{{end: 1, step: 1}}]}}\n", ":6: sweep.1.time: would undo time.step of"),
    (f"{SWEEP}set: {{time.step: 0.1}}\n", ":5: sweep.0.time.step: would undo time.step of set"),
    (f"{SWEEP}set: {{a.b: 1, a: 2}}\n", ":6: set.a: would undo a.b"),
    (f"{SWEEP}set: {{case: x.yaml}}\n", "the case is named by the key 'case' of the study"),
    (f"{SWEEP}cost: [time]\n", "unknown measure of cost 'time'"),
    (f"{SWEEP}cost: [wall, wall]\n", "wall is in the list already"),
    (f"{SWEEP}ranks: 1.5\n", ":6: ranks: expected a whole number"),
    (f"{SWEEP}timeout: 0\n", ":6: timeout: must be above 0"),
    (f"{SWEEP}launcher: mpirun\n", ":6: launcher: expected a list"),
    (f"{SWEEP}launcher: ['', -n]\n", "the first word is the program"),
    (f"{SWEEP}plot: {{x: time.stop}}\n", ":6: plot.x: the case has no time.stop; swept are"),
    (f"{SWEEP}plot: {{x: method.shape}}\n", "method.shape is gimp, not a number (run step-0.1 and"),
    (f"{SWEEP}plot: {{group: methd}}\n", ":6: plot.group: the case has no methd"),
    # What no history will have, in the words of the study, before a run starts.
    (
        f"{SWEEP}columns: [porosity, mass]\n",
        ":6: columns.0: unknown column 'porosity'; history.csv will have: body.bar.centre-x,",
    ),
    (
        f"{SWEEP}columns: [{{column: strain-energie, at: 0.5}}]\n",
        ":6: columns.0.column: unknown column 'strain-energie'; did you mean 'strain-energy'?",
    ),
    (
        f"{SWEEP}columns: [{{column: mass, at: 1.5}}]\n",
        ":6: columns.0.at: 1.5 is after the end at 1 (time.end)",
    ),
    (f"{SWEEP}columns: [{{column: a, at: begin}}]\n", "columns.0.at: unknown value 'begin'"),
    (f"{SWEEP}columns: [{{column: a, relative: true}}]\n", "needs a reference other than 0"),
    # Wrong cases: at the value of the study, or where the case has what does not fit it.
    ("sweep: [{time.step: [0.1, -1]}]\n", ":4: sweep.0.time.step.1: time.step: must be above 0"),
    ("sweep: [{time.stop: [1]}]\n", ":4: sweep.0.time.stop.0: time.stop: unknown key"),
    ("sweep: [{grid.cell: [[0.7]]}]\n", "falling.yaml:4: grid.size.0: 12 is not a whole number"),
    ("sweep: [{time.end.x: [1]}]\n", ":4: sweep.0.time.end.x.0: time.end is 1 and has no key 'x'"),
    ("sweep: [{case: [nowhere.yaml, 3]}]\n", ":4: sweep.0.case.0: cannot read the case"),
    ("sweep: [{case: [nowhere.yaml, 3]}]\n", "expected the name of a case file, got 3"),
    (f"sweep: [{{a: {list(range(200))}}}, {{b: {list(range(200))}}}]\n", "40000 runs are too many"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_a_wrong_study_is_named_with_its_place(tmp_path, text, message):
    path = put(tmp_path, HEAD + text)
    with pytest.raises(CaseError) as caught:
        read_plan(path)
    assert message in str(caught.value)
    assert not re.search(r"Input should|pydantic|tuple|dict\b|None|Traceback", str(caught.value))


@pytest.mark.parametrize(
    ("error", "message"),
    [
        ("error", ":3: error: unknown column 'error'; history.csv will have: body.bar.centre-x,"),
        ("{column: momentum-y}", "error.column: unknown column 'momentum-y'; did you mean 'mom"),
        ("{column: mass, at: 2.0}", "error.at: 2 is after the end at 1 (time.end) (run step-0.1"),
    ],
)
def test_an_error_that_no_history_has_is_named_before_any_run(tmp_path, error, message):
    with pytest.raises(CaseError) as caught:
        read_plan(put(tmp_path, f"format: 1\ncase: cases/falling.yaml\nerror: {error}\n{SWEEP}"))
    assert message in str(caught.value)


def test_a_further_column_may_be_missing_in_some_runs(tmp_path):
    sweep = "sweep: [{boundaries: [{x-min: fixed}, {}]}]\nplot: {x: time.end}\n"
    assert len(read_plan(put(tmp_path, f"{HEAD}{sweep}columns: [reaction.x-min-x]\n")).runs) == 2
    with pytest.raises(CaseError, match=r"error: unknown column 'reaction.x-min-x'.*\(run .*\)$"):
        wanted = HEAD.replace("kinetic-energy", "reaction.x-min-x")
        read_plan(put(tmp_path, wanted + sweep))


def test_a_study_without_case_or_file(tmp_path):
    with pytest.raises(CaseError, match=r"case: missing \(the case file"):
        read_plan(put(tmp_path, f"format: 1\nerror: mass\n{SWEEP}"))
    with pytest.raises(UsageError, match=r"cannot read the study .*: Is a directory"):
        read_plan(tmp_path)
    swept = "format: 1\nerror: mass\nsweep: [{case: [cases/falling.yaml]}]\n"
    (run,) = read_plan(put(tmp_path, swept)).runs
    assert (run.name, run.options, run.values) == ("falling", (), {"case": "cases/falling.yaml"})


def test_the_json_schema_takes_what_the_reader_takes():
    check = Checker(study_schema())
    rest = """
set: {time.end: 1}
columns: [mass, {column: a, at: 2.0, reference: -1, relative: true}, {column: b, at: max}]
cost: [core]
ranks: 2
launcher: [srun]
timeout: 10
folder: there
plot: {x: time.step, group: [a, b]}
"""
    for text in (HEAD + SWEEP, HEAD + SWEEP + rest, HEAD + SWEEP + "plot: {group: a}\n"):
        data = parse(text, "study").data
        assert check(data)
        Study.model_validate(data)
    for wrong in ("swep: 1", "ranks: 0", "plot: {y: 1}", "columns: [{at: end}]", "launcher: []"):
        data = parse(f"{HEAD}{SWEEP}{wrong}\n", "study").data
        assert not check(data)
        with pytest.raises(ValueError):
            Study.model_validate(data)


def test_the_last_words_of_a_run():
    rest = "\n  run.out holds 1 frame, to t = 0, and history.csv\n"
    place = "rank 1: it broke\n  in step 7"
    assert last_words(f"noise\npgimp: {place}{rest}", 1) == "rank 1: it broke in step 7"
    advice = f"\n  try: smaller steps{rest}"
    assert last_words(f"pgimp: {place}{advice}", 1) == "rank 1: it broke in step 7"
    launcher = "\n-----\nmpirun has exited due to process rank 0\n-----\n"
    assert last_words(f"pgimp: no\nsuch thing{launcher}", 1) == "no such thing"
    mentions(last_words("", 5), "status 5", "nothing")
    mentions(last_words("", -9), "SIGKILL")
    assert last_words("=====\nnot as root\n\nat all\n=====\n", 1) == "not as root at all"
    trace = "Traceback (most recent call last):\n  File x\n    y\nValueError: z\n"
    assert last_words(trace, 1).endswith("ValueError: z")
    assert len(last_words("x" * 10_000, 1)) == 600


def test_the_study_of_a_case_has_three_sizes_and_whole_steps(tmp_path):
    """Fixed steps in proportion to the cells; the last run has those of the case."""
    put(tmp_path)
    path = tmp_path / "accuracy.yaml"
    path.write_text(study_of(tmp_path / "cases" / "falling.yaml", path))
    plan = read_plan(path)
    assert [one.x for one in plan.runs] == [4.0, 2.0, 1.0]
    steps = [float(one.values["time.step"]) for one in plan.runs]
    assert steps == pytest.approx([0.1, 0.05, 0.025])
