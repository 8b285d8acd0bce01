"""Checkpoints whose checksums are right and whose header lies: refused, without harm."""

import json
import tracemalloc
import zlib

import numpy as np
import pytest
from checkpoint_source import write_on

from pgimp.io.checkpoints.checkpointfile import LAYOUT, CheckpointFile, DamagedError
from pgimp.mpi.comm import Serial

COUNT = 12
DELETE = object()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "file.h5"
    write_on(Serial(), path, COUNT)
    return path.read_bytes()


def parts(data):
    line, _, rest = data.partition(b"\n")
    text = rest.split(b"\0", 1)[0]
    begin = json.loads(text)["pieces"][0][0]
    return line, text, data[begin:]


def with_text(data, text, length=None, checksum=None, layout=LAYOUT):
    """The file with another header; its line fits the text unless told otherwise."""
    _, old, rest = parts(data)
    begin = json.loads(old)["pieces"][0][0]
    length = len(text) if length is None else length
    checksum = zlib.crc32(text) if checksum is None else checksum
    line = f"pgimp checkpoint, layout {layout}, header of {length} bytes, CRC-32 {checksum:08x}\n"
    return (line.encode() + text).ljust(begin, b"\0") + rest


def dump(tree):
    return json.dumps(tree, ensure_ascii=False, separators=(",", ":")).encode()


def change(tree, path, value):
    *way, last = path
    for key in way:
        tree = tree[key]
    if value is DELETE:
        del tree[last]
    else:
        tree[last] = value


@pytest.fixture
def open_bounded(tmp_path):
    """Open and read all of a file; more than a few megabytes at a time is an error."""

    def check(data):
        path = tmp_path / "file.h5"
        path.unlink(missing_ok=True)
        path.write_bytes(data)
        tracemalloc.start()
        try:
            file = CheckpointFile(path)
            file.verify(0, 1)
            for name in file.rows:
                assert file.read(name, 0, file.count).shape == (file.count, *file.rows[name][1])
            for name in file.whole:
                assert file.read_whole(name).shape == file.whole[name][1]
        except DamagedError as error:
            assert len(str(error)) < 200 and str(error).isprintable(), str(error)
            raise
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            assert peak < (10 << 20) + 20 * len(data), peak

    return check


def place(dtype="<f8", shape=(3,), offset=4096):
    return {"dtype": dtype, "shape": list(shape), "offset": offset}


LIES = [
    (("rows", "x", "shape"), value, why)
    for value, why in [
        ([2**40], "beyond the end"),
        ([2**62, 2**62], "beyond the end"),
        ([0, 2**62], "beyond the end"),
        ([2**63], "rows.x.shape|too large"),
        ([-3], "greater than or equal to 0"),
        ([True], "valid integer"),
        (["3"], "valid integer"),
        ([3.0], "valid integer"),
        ([1] * 9, "at most 8"),
        (3, "valid list"),
        (None, "valid list"),
        ([20], "overlap"),
    ]
]
LIES += [
    (("rows", "x", "offset"), value, why)
    for value, why in [
        (-8, "greater than or equal to 0"),
        (0, "overlap"),
        (2**62, "beyond the end"),
        (2**63 - 1, "beyond the end"),
        (2**70, "too large"),
        (10**30, "too large"),
        (1.5, "valid integer"),
    ]
]
LIES += [
    (("rows", "x", "dtype"), value, "rows.x.dtype")
    for value in ("|O", "O", ">f8", "<f8,<f8", "<U1000000000", "object", "", None, "<c16")
]
LIES += [
    (("count",), -1, "greater than or equal to 0"),
    (("count",), 2**62, "contradicts itself"),
    (("count",), 10 * COUNT, "overlap|beyond the end"),
    (("count",), 12.0, "valid integer"),
    (("count",), None, "valid integer"),
    (("count",), DELETE, "count: Field required"),
    (("size",), 1, "not the 1 that were written"),
    (("size",), 2**62, "that were written"),
    (("about",), [], "about"),
    (("about",), {"n": 2**63}, "too large"),
    (("extra",), 1, "extra"),
    (("rows", "../x"), place(), "rows"),
    (("rows", "x\n"), place(), "rows"),
    (("rows", ""), place(), "rows"),
    (("rows", "x" * 5000), place(), "rows"),
    (("rows", "x", "more"), 1, "more"),
    (("rows", "layers"), place(), "contradicts itself"),
    (("whole", "huge"), place(shape=(2**33,)), "beyond the end"),
    (("whole", "huge"), place(shape=(2**31, 2**31, 2**31)), "beyond the end"),
    (("whole", "huge"), place(shape=(0, 2**62, 2**62)), "beyond the end"),
    (("pieces",), [], "where the data begin"),
    (("pieces",), DELETE, "pieces"),
    (("pieces",), {}, "pieces"),
    (("pieces", 0), DELETE, "where the data begin"),
    (("pieces", 1), DELETE, "piece by piece"),
    (("pieces", -1), DELETE, "to its end"),
    (("pieces", 0, 0), 0, "where the data begin"),
    (("pieces", 0, 0), 512, "where the data begin"),
    (("pieces", 0, 0), 2**62, "where the data begin"),
    (("pieces", 0, 0), 4095, "where the data begin"),
    (("pieces", 0, 1), 0, "piece by piece"),
    (("pieces", 0, 1), 2**62, "piece by piece|to its end"),
    (("pieces", -1, 1), 2**62, "to its end"),
    (("pieces", 0, 1), -5, "greater than or equal to 0"),
    (("pieces", 0, 2), 2**32, "piece by piece"),
    (("pieces", 0, 2), 0, "do not have their checksum"),
    (("pieces", 0), [], "at least 3"),
    (("pieces", 0), [1, 2, 3, 4], "at most 3"),
]


@pytest.mark.parametrize(("path", "value", "why"), LIES)
def test_lies_are_refused(whole, open_bounded, path, value, why):
    tree = json.loads(parts(whole)[1])
    change(tree, path, value)
    with pytest.raises(DamagedError, match=why):
        open_bounded(with_text(whole, dump(tree)))


TEXTS = {
    "": "does not begin like",
    "{": "cannot be read",
    "3": "its top",
    "[]": "its top",
    "null": "its top",
    "{}": "size: Field required",
    "[" * 100_000: "cannot be read",
    '{"a":' * 100_000: "cannot be read",
    "[" * 100 + "]" * 100: "nested too deeply",
    "[" * 500_000 + "]" * 500_000: "cannot be read",
    "NaN": "cannot be read",
    "[1e999]": "cannot be read",
    "[-Infinity]": "cannot be read",
    "9" * 10_000: "cannot be read",
    "9" * 4000: "too large",
    "[" + "[]," * 300_000 + "[]]": "its top",
    '{"size":1,"size":2}': "not written as",
    '{"size": 1}': "not written as",
    "[1.0e0]": "not written as",
    '["\\u0041"]': "not written as",
    '["\\ud800"]': "cannot be read",
    "\ufeff{}": "not written as",
    "x = 1": "cannot be read",
}


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: text[:12])
def test_texts_that_are_no_header(whole, open_bounded, text):
    with pytest.raises(DamagedError, match=TEXTS[text]):
        open_bounded(with_text(whole, text.encode()))


@pytest.mark.parametrize("coding", ["utf-16", "utf-32", "latin-1"])
def test_other_encodings(whole, open_bounded, coding):
    text = parts(whole)[1].decode().encode(coding, errors="replace")
    with pytest.raises(DamagedError, match=r"cannot be read|not written as"):
        open_bounded(with_text(whole, text))


def test_first_lines_that_lie(whole, open_bounded):
    _, text, _ = parts(whole)
    for told, why in [
        ({"length": 999_999_999}, "the most there can be"),
        ({"length": 10_000_000}, "its checksum"),
        ({"length": len(text) + 1}, "its checksum"),
        ({"length": len(text) - 1}, "its checksum"),
        ({"length": 10**12}, "does not begin like"),
        ({"length": 0}, "does not begin like"),
        ({"checksum": 0}, "its checksum"),
        ({"layout": 1}, f"it has layout 1, and this version of pgimp reads {LAYOUT}"),
        ({"layout": 10**20}, "does not begin like"),
        ({"layout": "1 "}, "does not begin like"),
        ({"layout": "\u0661"}, "does not begin like"),
    ]:
        with pytest.raises(DamagedError, match=why):
            open_bounded(with_text(whole, text, **told))


def test_the_header_may_not_reach_into_the_data(whole, open_bounded):
    """A text longer than the user block, with a checksum that is right for what is there."""
    begin = json.loads(parts(whole)[1])["pieces"][0][0]
    tree = json.loads(parts(whole)[1])
    tree["about"] = {"padding": "x" * begin}
    last = tree["pieces"][-1][1]
    for _ in range(3):  # the numbers may get longer
        data = with_text(whole, dump(tree))
        tree["size"] = len(data)
        tree["pieces"][-1][1] = last + len(data) - len(whole)
    with pytest.raises(DamagedError, match="where the data begin"):
        open_bounded(with_text(whole, dump(tree)))


def test_a_file_without_data(whole, open_bounded):
    tree = json.loads(parts(whole)[1])
    begin = tree["pieces"][0][0]
    tree |= {"size": begin, "count": 0, "rows": {}, "whole": {}, "pieces": [[begin, 0, 0]]}
    with pytest.raises(DamagedError, match="piece by piece"):
        open_bounded(with_text(whole, dump(tree))[:begin])


NASTY = [0, 1, -1, 7, 511, 4096, 2**31, 2**32, 2**53, 2**63 - 1, 2**64, 0.5, True, None, "", "x"]
NASTY += ["<f8", "<i4", "|O", [], {}, [0], [2**40, 0], [[]], "\n", "\x1b[2J", DELETE]


def leaves(tree, path=()):
    """Paths to everything in a header."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


def test_300_random_lies(whole, open_bounded):
    """Refused, or harmless: a file that is accepted can be read, in the size it has."""
    random = np.random.default_rng(9)
    accepted = 0
    for _ in range(300):
        tree = json.loads(parts(whole)[1])
        for _ in range(random.integers(1, 3)):
            paths = [path for path in leaves(tree) if path[0] != "about"]
            path = paths[random.integers(len(paths))]
            change(tree, path, NASTY[random.integers(len(NASTY))])
        try:
            open_bounded(with_text(whole, dump(tree)))
            accepted += 1
        except DamagedError:
            pass
    assert accepted < 50
