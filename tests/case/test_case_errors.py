"""Bad cases by the dozen: each message says where, what, and what would be right."""

import re

import meshio
import numpy as np
import pytest
from bad_cases import GOOD, MISTAKES
from hypothesis import given, settings
from hypothesis import strategies as st
from mentioned import mentions

from pgimp.case.load import load
from pgimp.case.reader import dump_case, read_case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.geometry import share
from pgimp.scene.scene import Scene

JARGON = re.compile(
    r"Input should|pydantic|validation|\btuple\b|\bdict\b|\bNone\b|Traceback|_type\b|<class|\bctx\b"
)


def lines_of(text, *overrides):
    """The lines of the message about a bad case."""
    with pytest.raises(CaseError) as caught:
        read_case(text, "case.yaml", list(overrides))
    assert not JARGON.search(str(caught.value)), caught.value
    return str(caught.value).splitlines()


def test_the_good_case_is_good():
    assert read_case(GOOD, "case.yaml").title == "Two bodies"


@pytest.mark.parametrize(("old", "new", "where", "parts"), [(*m[:3], m[3:]) for m in MISTAKES])
def test_a_mistake_is_named_with_its_place(old, new, where, parts):
    assert old in GOOD
    (line,) = lines_of(GOOD.replace(old, new, 1))
    assert line.startswith(f"case.yaml:{where}")
    for part in parts:
        assert part in line


def test_types_of_the_wrong_dimension():
    text = GOOD.replace("model: hooke", "model: linear-1d").replace("    poisson: 0.3\n", "")
    (line,) = lines_of(text)
    assert line.startswith("case.yaml:12: materials.steel.model: ")
    mentions(line, "linear-1d", "1D only", "2D")


def test_rotation_needs_a_vector_in_3d_and_does_not_exist_in_1d():
    one = """{format: 1, dimensions: 1, grid: {size: [4], cell: [1]}, time: {end: 1, step: 1},
    method: {shape: mpm, particles-per-cell: [1]}, materials: {m: {model: linear-1d, young: 1,
    density: 1}}, bodies: {b: {material: m, region: {box: {min: [0], max: [1]}},
    velocity: {rotation: {about: [0], rate: 1}}}}}"""
    (line,) = lines_of(one)
    assert "there is no rotation in one dimension" in line
    three = one.replace("dimensions: 1", "dimensions: 3").replace(
        "linear-1d, ", "hooke, poisson: 0, "
    )
    for key in ("size: [4]", "cell: [1]", "particles-per-cell: [1]", "about: [0]", "min: [0]"):
        number = key[key.index("[") + 1 : -1]
        three = three.replace(key, key.replace(number, ", ".join([number] * 3)))
    three = three.replace("max: [1]", "max: [1, 1, 1]")
    (line,) = lines_of(three)
    mentions(line, "velocity.rotation.rate: ", "vector", "axis", "3D", "got 1")
    rates = read_case(three.replace("rate: 1", "rate: [0, 0, 1]")).bodies["b"].velocity.rotation
    assert rates.rate == (0.0, 0.0, 1.0)


def test_all_mistakes_at_once_in_the_order_of_the_file():
    text = GOOD.replace("young:", "yuong:").replace("end: 1.0", "end: 1.0004")
    text = text.replace("x-min: fixed", "z-min: fixed").replace("[stress]", "[stres]")
    lines = lines_of(text.replace("    material: steel\n    region: {ball", "    region: {bal"))
    assert [line.split(": ")[:2] for line in lines] == [
        ["case.yaml:8", "time.end"],
        ["case.yaml:13", "materials.steel.yuong"],
        ["case.yaml:17", "bodies.left.material"],
        ["case.yaml:18", "bodies.left.region.bal"],
        ["case.yaml:26", "boundaries.z-min"],
        ["case.yaml:28", "output.fields.0"],
    ]


def test_a_mistake_in_one_body_does_not_hide_that_in_another():
    text = GOOD.replace("velocity: [1.0, 0.0]", "velocity: fast").replace(
        "[8.0, 4.0]", "[8.0, 7.0]"
    )
    left, right = lines_of(text)
    assert left.startswith("case.yaml:20: bodies.left.velocity: ")
    mentions(left, "number", "direction")
    assert right.startswith("case.yaml:23: bodies.right.region: ")
    mentions(right, "1 beyond", "domain")


def test_a_body_is_not_blamed_for_a_mistake_in_its_material():
    (line,) = lines_of(GOOD.replace("young: 1.0e6", "young: -1"))
    assert "materials.steel.young" in line
    (line,) = lines_of(GOOD, "materials={}")
    assert line.startswith("--set materials={}: materials: ")
    mentions(line, "at least 1", "{}")


def test_at_most_ten_lines():
    text = GOOD.replace("history:", "\n".join(f"key{i}: 1" for i in range(30)) + "\nhistory:")
    lines = lines_of(text)
    assert len(lines) == 10
    assert lines[0].startswith("case.yaml:30: key0:")
    mentions(lines[-1], "case.yaml", "21 more")


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("time.stepp=1", "--set time.stepp=1: time.stepp: unknown key; did you mean 'step'?"),
        ("time.end=1.0004", "--set time.end=1.0004: time.end: 1.0004 is not a whole number"),
        ("tiem.end=1", "--set tiem.end=1: tiem: unknown key; did you mean 'time'?"),
        ("grid.size.0=10.2", "--set grid.size.0=10.2: grid.size.0: 10.2 is not a whole number"),
        ("grid.size.2=1", "--set grid.size.2=1: grid.size is a list with the entries 0 to 1"),
        ("grid.size.x=1", "--set grid.size.x=1: grid.size is a list with the entries 0 to 1"),
        ("grid.size.-1=1", "--set grid.size.-1=1: grid.size is a list"),
        ("time.end.x=1", "--set time.end.x=1: time.end is 1 and has no key 'x'"),
        ("time.step={courant:1}", "time.step.courant:1: unknown key; a space is missing"),
        ("time.step={courant: 2}", "time.step.courant: must be at most 1, got 2"),
        ("time.step=[1", "--set time.step=[1: a ',' or the closing ']' is missing"),
        ("time.step=", "--set time.step=: time.step: expected a step above zero"),
        ("time.step", "--set time.step: expected KEY.PATH=VALUE"),
        ("=1", "--set =1: expected KEY.PATH=VALUE"),
        ("time..end=1", "--set time..end=1: expected KEY.PATH=VALUE"),
        ("", "--set : expected KEY.PATH=VALUE"),
        ("output.every=-1", "--set output.every=-1: output.every: must be above 0, got -1"),
        ("bodies.left={}", "--set bodies.left={}: bodies.left.material: missing"),
    ],
)
def test_a_bad_override_is_named(override, message):
    assert any(message in line for line in lines_of(GOOD, override))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "case.yaml: the file is empty; a case starts with 'format: 1'"),
        (b"# nothing\n", "case.yaml: the file is empty; a case starts with 'format: 1'"),
        (
            b"- 1\n- 2\n",
            "case.yaml: expected keys with values, such as 'format: 1', got a list of 2",
        ),
        (
            b"hello",
            "case.yaml: expected keys with values, such as 'format: 1', got the text 'hello'",
        ),
        (b"\x89HDF\r\n\x1a\n\0\0", "case.yaml: a binary file, not a case file"),
        (b"format: 1\ntitle: Stra\xdfe\n", "case.yaml:2: the byte 0xdf is not UTF-8"),
        ("format: 1".encode("utf-16"), "case.yaml: UTF-16 text; save the file as UTF-8"),
        ("format: 1".encode("utf-16-be"), "case.yaml: a binary file"),
        (b"a: " + b"x" * 4_000_000, "case.yaml: too large for a case file (at most 4,000,000"),
    ],
)
def test_a_file_that_is_no_case(content, message):
    (line,) = lines_of(content)
    assert line.startswith(message)


@pytest.mark.parametrize(
    "text",
    ["[" * 10**6, "{a: " * 10**6, "- " * 10**6, "? " * 10**6, "a: " * 10**6, "&a " * 10**6,
     "a: [" + "[0], " * 10**4, "'" + "x " * 10**5, "%" * 10**6, "a: " + "9" * 10**6],
    ids=lambda text: text[:5],
)  # fmt: skip
def test_hostile_files_are_refused_with_short_messages(text):
    assert all(len(line) < 300 for line in lines_of(text))


def test_a_bad_case_is_exit_status_2_without_a_traceback(tmp_path, capsys):
    path = tmp_path / "case.yaml"
    path.write_text(GOOD.replace("young:", "yuong:"))
    assert main([str(path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert "case.yaml:13: materials.steel.yuong: unknown key; did you mean 'young'?" in error
    assert "Traceback" not in error
    assert not (tmp_path / "out").exists()


@settings(max_examples=150, deadline=None)
@given(
    place=st.integers(0, len(GOOD) - 1),
    removed=st.integers(0, 8),
    put=st.text(st.sampled_from("{}[]:,-'\"#&*!|>%@ \n\t0.5exn\0é"), max_size=6),
)
def test_any_damage_gives_a_case_or_a_message(place, removed, put):
    text = GOOD[:place] + put + GOOD[place + removed :]
    try:
        case = read_case(text, "case.yaml")
    except CaseError as error:
        assert all(line.startswith("case.yaml") for line in str(error).splitlines())
    else:
        assert read_case(dump_case(case)) == case


def located_mistakes():
    """Cases that only their geometry shows to be wrong: text in place of the region of `b`."""
    return {
        "overlap": ("{box: {min: [1.0, 1.0], max: [3.0, 3.0]}}", "overlap in the box of "),
        "points": ("{points: {file: p.csv}}", "missing volume. Expected x,y,volume"),
        "twins": ("{points: {file: twins.csv}}", "2 particles of "),
        "mesh": ("{mesh: {file: m.vtu}}", "open ends, the first at (5, 5), of segment 0 (from 0)"),
        "beyond": ("{points: {file: far.csv}}", "reaches 1 beyond the domain at x-max"),
        "nothing": (
            "{box: {min: [5.1, 5.1], max: [5.2, 5.2]}}\n    surface: whole-particles",
            "contains no particle",
        ),
    }


@pytest.mark.parametrize("name", located_mistakes())
def test_mistakes_of_geometry_have_file_and_line(tmp_path, name):
    region, text = located_mistakes()[name]
    (tmp_path / "p.csv").write_text("x,y\n1,1\n")
    (tmp_path / "twins.csv").write_text("x,y,volume\n5,5,0.1\n5,5,0.1\n")
    (tmp_path / "far.csv").write_text("x,y,volume\n9,5,0.1\n")
    corners, lines = np.array([[5.0, 5, 0], [6, 5, 0], [6, 6, 0]]), np.array([[0, 1], [1, 2]])
    meshio.write_points_cells(tmp_path / "m.vtu", corners, [("line", lines)])
    (tmp_path / "c.yaml").write_text(
        "format: 1\ndimensions: 2\ngrid: {size: [8.0, 8.0], cell: [1.0, 1.0]}\n"
        "method: {shape: gimp, particles-per-cell: [2, 2]}\ntime: {end: 1.0, step: 0.01}\n"
        "materials:\n  soft: {model: neo-hookean, young: 100.0, poisson: 0.3, density: 1.0}\n"
        "bodies:\n  a:\n    material: soft\n    region: {box: {min: [2.0, 2.0], max: [4.0, 4.0]}}\n"
        f"  b:\n    material: soft\n    region: {region}\n"
    )
    given = f"bodies.b.region={region}"
    for overrides, place in (([], f"{tmp_path / 'c.yaml'}:14"), ([given], f"--set {given}")):
        if overrides and "surface" in region:
            continue
        case = load(tmp_path / "c.yaml", overrides)
        with pytest.raises(CaseError) as error:
            share(case, Serial())
            count_particles(Scene(case), Serial())
        assert str(error.value).startswith(f"{place}: bodies.b.region: "), str(error.value)
        assert text in str(error.value)


IDLE = """\
materials:
  clay: {model: von-mises, young: {table: [[0, 1.0e6], [6, 2.0e6]], over: y}, poisson: 0.3,
    density: 1.0, yield-stress: 1.0e3}
"""


@pytest.mark.parametrize("field", ["plastic-strain", "parameter-young"])
def test_fields_of_materials_that_no_body_has(field):
    text = GOOD.replace("materials:\n", IDLE).replace("[stress]", f"[{field}]")
    (line,) = lines_of(text)
    assert line.startswith("case.yaml:31: output.fields.0: ")
    mentions(line, "no body is of a material that has it ('clay')", "there are: ", "stress")


def test_fields_that_every_frame_has():
    """They are known, and need no name."""
    (line,) = lines_of(GOOD.replace("[stress]", "[volume]"))
    mentions(line, "output.fields.0", "every frame has volume", "leave it out")


def test_a_rigid_body_is_no_unknown_one():
    rigid = "  punch: {rigid: {}, region: {box: {min: [0, 5], max: [1, 6]}}}\ngravity:"
    entries = """
tractions: {t: {body: punch, face: x-min, pressure: 1.0}}
constraints: {c: {body: punch, region: {box: {min: [0, 5], max: [1, 6]}}, velocity: [0, 0]}}
probes: {p: {body: punch, at: [0.5, 5.5]}}
"""
    lines = lines_of(GOOD.replace("gravity:", rigid) + entries)
    keys = [line.split(": ")[1] for line in lines]
    assert keys == ["tractions.t.body", "constraints.c.body", "probes.p.body"]
    for line, words in zip(lines, ("traction", "constraint", "history.csv"), strict=True):
        mentions(line, "'punch' is rigid, and has no particles", words)
