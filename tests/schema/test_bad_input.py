"""Files that are no cases, and cases that would do harm: refused in a few words, and soon."""

import re
import sys
from pathlib import Path
from time import process_time

import pytest
from bad_cases import BALL, GOOD
from processes import run

from pgimp.case.reader import read_case
from pgimp.errors import CaseError

pytestmark = pytest.mark.slow(30)

PROOFS = Path(__file__).resolve().parents[2] / "scripts" / "proofs"
BOMB = "l0: &l0 lol\n" + "".join(
    f"l{i}: &l{i} [{', '.join([f'*l{i - 1}'] * 9)}]\n" for i in range(1, 12)
)


def test_mutated_cases_are_refused_or_run():
    job = run([sys.executable, str(PROOFS), "cases", "--short", "--runs", "108"], 300)
    assert job.returncode == 0, job.stdout + job.stderr
    refused, good = (int(re.search(rf"in all:.*?(\d+) {what}", job.stdout)[1]) for what in
                     ("refused", "good"))  # fmt: skip
    assert refused > 80 and good > 5


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "'&l0': a case file has no anchors"),
        ("format: !!python/object/apply:os.system [touch harm]", "the tag '!!python"),
        (GOOD.replace("format: 1", "format: !!int 1"), "the tag"),
        (GOOD + "base: &b {end: 1}\n", "no anchors and aliases"),
        (GOOD + "<<: {time: {end: 1}}\n", "<<: unknown key"),
        ("[" * 10**6, "nested deeper than 32 levels"),
        ("".join(f"key{i}: 1\n" for i in range(9000)), "and 991 more"),
        ("a: 1\n" * 9000, "and 8990 more"),
        (GOOD.replace("1.0e6", "1" * 100_000 + "x"), "expected a number"),
        (GOOD.replace("[stress]", "[" + "x, " * 9000 + "x]"), "unknown field 'x'"),
        (GOOD.replace("[0.55]", "[" + "9, " * 9000 + "9]"), "9 is after the end at 1"),
        (GOOD.replace(BALL, f"{{union: [{', '.join([BALL] * 6000)}]}}"), "6,000 regions in one"),
        (GOOD.replace("  left:", f"  {'l' * 100_000}:"), "a colon that cannot stand here"),
        (GOOD.replace("  left:", f"  ? {'l' * 100_000}\n  :"), "a name starts with a letter"),
        (GOOD + f"? {'k' * 100_000}\n: 1\n", "unknown key"),
        ("\ufeff" * 3 + GOOD, "U+FEFF) in or beside the key 'format'"),
        (GOOD.replace("  left:", "\u00a0\u00a0left:"), "a non-breaking space (U+00A0) in or"),
        (GOOD.replace("format: 1", "format:\u00a01"), "a non-breaking space (U+00A0) in line 1"),
        (GOOD.replace("[0.55]", "[\u20090.55]"), "a space of another kind (U+2009)"),
        (GOOD.replace("1.0e6", "1.0e\u22126"), "a typographic minus (U+2212); write the number"),
        (GOOD.replace("materials:", "mate\u2010rials:"), "(U+2010) in or beside the key 'mate"),
        (GOOD.encode("utf-16"), "UTF-16 text"),
        (GOOD.encode("utf-32-le"), "a binary file"),
        (GOOD.replace("Two", "Zwölf").encode("latin-1"), "the byte 0xf6 is not UTF-8"),
        (b"\x00" * 10**6, "a binary file"),
        (GOOD.replace("Two", "T\x1b[2J"), "U+001B does not belong in a text file"),
    ],
    ids=lambda item: str(item)[:20].replace("\0", "0"),
)
def test_the_nastiest_by_hand(text, words):
    with pytest.raises(CaseError) as caught:
        read_case(text, "case.yaml")
    lines = str(caught.value).splitlines()
    assert len(lines) <= 10 and all(len(line) < 400 and line.isprintable() for line in lines)
    assert any(words in line for line in lines), lines


def refusal_of_a_token(begin):
    """Words by which a token of megabytes is refused, and CPU seconds until then."""
    text = f"a: 1\n{begin}{'a' * 2_000_000} 1\n"
    began = process_time()
    with pytest.raises(CaseError) as caught:
        read_case(text, "case.yaml")
    return str(caught.value), process_time() - began


@pytest.fixture(scope="module")
def comment():
    """CPU seconds that reading a long comment takes."""
    return refusal_of_a_token("#")[1]


@pytest.mark.parametrize("begin", ["!", "!<", "!a!", "!%41", "&", "*", "[!", "? !", "%"])
def test_a_token_of_megabytes_takes_no_longer_than_its_length(begin, comment):
    """Of what a case has no use for, the scanner took minutes, growing with the square.

    Against a comment as long: 0.02 times for most, 1.3 for a directive.
    """
    words, seconds = refusal_of_a_token(begin)
    assert seconds < 4.0 * comment
    assert len(words) < 400


def test_more_values_than_anyone_writes_are_refused(monkeypatch):
    monkeypatch.setattr("pgimp.schema.document.MOST_VALUES", 1000)
    assert read_case(GOOD).title == "Two bodies"
    with pytest.raises(CaseError, match=r"case:1:\d+: more than 1,000 keys and values"):
        read_case("a: [" + "1, " * 1000 + "1]")


def test_no_number_of_overrides_and_no_path_does_harm():
    for override in (
        "a." * 10**5 + "b=1",
        "bodies" + ".left" * 40 + "=1",
        "title=" + "[" * 10**5,
        "grid.size.99999999999999999999=1",
        "x=" + "1, " * 10**5,
        "a=&a [*a]",
    ):
        with pytest.raises(CaseError) as caught:
            read_case(GOOD, "case.yaml", [override])
        assert len(str(caught.value)) < 400


@pytest.mark.parametrize("ranks", [1, 2])
def test_as_people_meet_it(tmp_path, mpirun, python, ranks):
    (tmp_path / "case.yaml").write_text(f"{GOOD}x: !!python/object/apply:os.system [touch harm]\n")
    words = ["-m", "pgimp", "case.yaml"]
    job = python(words, cwd=tmp_path) if ranks == 1 else mpirun(ranks, words, cwd=tmp_path)
    assert job.returncode == 2
    assert job.stderr.startswith("pgimp: case.yaml:31:4: the tag ")
    assert job.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.yaml"]


def test_files_that_never_end_are_read_no_further_than_needed(tmp_path, python):
    with open(tmp_path / "large.yaml", "wb") as stream:
        stream.truncate(10**12)  # takes no room
    program = (
        "from pgimp.cli import main\n"
        "print([main([*words, name]) for name in ('/dev/zero', 'large.yaml')"
        " for words in ([], ['check'], ['study'])])\n"
        "print(open('/proc/self/status').read().split('VmHWM:')[1].split()[0])"
    )
    job = python(["-c", program], cwd=tmp_path)
    status, kilobytes = job.stdout.splitlines()
    assert status == "[2, 2, 2, 2, 2, 2]"
    assert int(kilobytes) < 300_000
    assert job.stderr.count("too large for a case file") == 6


def test_a_title_that_the_terminal_cannot_show(tmp_path, python):
    text = GOOD.replace("Two", "Zwölf 😀").replace("[2, 2]", "[1000000, 1000000]")
    (tmp_path / "case.yaml").write_text(text, encoding="utf-8")
    words = ["-m", "pgimp", "check", "case.yaml"]
    job = python(words, cwd=tmp_path, env={"PYTHONIOENCODING": "ascii"})
    assert job.returncode == 2 and "too large" in job.stderr
    assert job.stdout.startswith("Zw\\xf6lf \\U0001f600 bodies: valid, but")
