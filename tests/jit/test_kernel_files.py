"""Files of compiled kernels: whose they are, whether they are whole, and who may write to them."""

import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np
import pytest
from cache_words import COMPILING

from pgimp.jit.compiled import cache, sealed
from pgimp.jit.compiled.cache import KernelCache, Store, announced, messages
from pgimp.jit.compiled.folder import Folder, cache_folder, preferred_folder
from pgimp.jit.kernel import kernel

pytestmark = pytest.mark.slow(30)

SEED = 20041


def hypotenuse(x, y):
    return (x * x + y * y) ** 0.5


def fresh(folder):
    """The function above as a new kernel, which has nothing compiled yet."""
    compiled = kernel(hypotenuse)
    compiled._cache = KernelCache(hypotenuse, folder)
    return compiled


def answer(folder):
    """What the kernel answers, and whether it was found."""
    compiled = fresh(folder)
    return compiled(3.0, 4.0), sum(compiled.stats.cache_hits.values()) == 1


@pytest.fixture
def one_file(tmp_path):
    """The file of a tiny kernel, alone in a folder."""
    messages()
    assert answer(tmp_path) == (5.0, False)
    assert answer(tmp_path) == (5.0, True)
    (path,) = tmp_path.iterdir()
    return path


def adding(number):
    return lambda x: x + number


def test_namesakes_have_files_of_their_own(tmp_path):
    """On one line, too; kernels that read variables of a function around them have none."""
    functions = [lambda x: x + 1.0, lambda x: x + 2.0, adding(3.0), adding(4.0)]
    for _ in range(2):
        for number, function in enumerate(functions):
            compiled = kernel(function)
            compiled._cache = KernelCache(function, tmp_path)
            assert compiled(0.5) == number + 1.5
    assert len([*tmp_path.iterdir()]) == 2


def test_a_flipped_bit_anywhere_is_found(one_file):
    """In the seal, in the pickles and in the machine code; what is compiled replaces the file."""
    whole, rng = one_file.read_bytes(), random.Random(SEED)
    places = [0, 14, 15, 46, 47, len(whole) - 1, *rng.sample(range(len(whole)), 200)]
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << rng.randrange(8)
        one_file.write_bytes(damaged)
        with pytest.raises(sealed.UntrustedError, match="its checksum is not that of its content"):
            sealed.read(one_file)
    assert answer(one_file.parent) == (5.0, False)
    (line,) = messages()
    assert line.startswith("compiled kernels were not used but compiled again: ")
    assert str(one_file) in line and "checksum" in line
    assert answer(one_file.parent) == (5.0, True)
    assert messages() == []


def test_files_that_are_cut_or_of_another_kind(one_file):
    whole = one_file.read_bytes()
    plain = whole[47:]  # as Numba writes them, without a checksum
    for content in (b"", whole[:-1], whole[:20], whole + b"\0", plain, b"not a pickle"):
        one_file.write_bytes(content)
        assert answer(one_file.parent) == (5.0, False)
        assert len(messages()) == 1
        assert answer(one_file.parent) == (5.0, True)


def test_whole_files_that_do_not_fit(one_file):
    """Another kernel's under this name; one that cannot be unpickled; one of no compiled code."""
    folder = one_file.parent
    key = pickle.loads(whole := sealed.read(one_file))
    other = fresh(folder)
    other(3, 4)
    (path,) = set(folder.iterdir()) - {one_file}
    shutil.copy(path, one_file)
    assert answer(folder) == (5.0, False)
    assert messages() == []  # it is only not this one
    for content in (whole[: len(pickle.dumps(key))], pickle.dumps(key) + pickle.dumps((1, 2))):
        sealed.write(one_file, content)
        assert answer(folder) == (5.0, False)
        assert len(messages()) == 1


def test_files_that_others_can_write(one_file):
    one_file.chmod(0o620)
    assert answer(one_file.parent) == (5.0, False)
    assert r"others may write to it (mode 0620)" in messages()[0]
    assert answer(one_file.parent) == (5.0, True)
    assert one_file.stat().st_mode & 0o777 == 0o600


def test_a_full_disk_does_not_stop_a_kernel(tmp_path, monkeypatch):
    def full(*args):
        raise OSError(28, "No space left on device")

    messages()
    monkeypatch.setattr(os, "replace", full)
    assert answer(tmp_path) == (5.0, False)
    assert messages() == [
        f"compiled kernels could not be kept in {tmp_path}: No space left on device"
    ]
    assert list(tmp_path.iterdir()) == []


WRITE = """
import sys
from pathlib import Path
from pgimp.jit.compiled.cache import Store, messages

store, first = Store(Path(sys.argv[1])), int(sys.argv[2])
print("begins", flush=True)
for turn in range(int(sys.argv[3])):
    for k in range(8):
        key = ("key", k)
        found = store.load("entry", key)
        assert found is None or found == [k] * 50_000, k
        if (turn + k + first) % 3 == 0:
            store.save("entry", key, [k] * 50_000)
assert messages() == [], messages()
"""


def test_several_write_and_read_at_once_and_some_are_killed(tmp_path):
    """Nobody sees a file that is not whole, or another's; what killed writers leave is not read."""
    words = [sys.executable, "-c", WRITE, str(tmp_path)]
    rng = random.Random(SEED)
    lasting = [subprocess.Popen([*words, str(k), "60"]) for k in range(2)]
    for k in range(4):
        process = subprocess.Popen([*words, str(k), "100000"], stdout=subprocess.PIPE)
        assert process.stdout.readline() == b"begins\n"
        time.sleep(0.2 * rng.random())
        process.send_signal(signal.SIGKILL)
        process.communicate()
    assert [process.wait(timeout=100) for process in lasting] == [0, 0]
    store = Store(tmp_path)
    assert all(store.load("entry", ("key", k)) == [k] * 50_000 for k in range(8))


def test_what_is_compiled_is_announced_once(tmp_path):
    said = []
    with announced(said.append):
        fresh(tmp_path)(3.0, 4.0)
        fresh(tmp_path)(3, 4)
    assert said == [COMPILING]
    with announced(said.append):
        fresh(tmp_path)(3.0, 4.0)
    fresh(tmp_path)(np.float32(3), np.float32(4))
    assert said == [COMPILING] and cache._listeners == []


def test_folders_that_others_can_write_to_are_not_used(tmp_path, monkeypatch):
    """The one wanted, the one around it, behind a link; but one like /tmp will do."""
    base, temporary = tmp_path / "base", tmp_path / "tmp"
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    temporary.mkdir()
    link = tmp_path / "link"
    link.symlink_to(base)
    for path in (base, link):
        monkeypatch.setenv("PGIMP_CACHE_DIR", str(path))
        wanted = preferred_folder()
        assert cache_folder() == Folder(wanted)
        assert wanted.stat().st_mode & 0o777 == base.stat().st_mode & 0o777 == 0o700
        for whose, mode, fits in [
            (base, 0o777, False),
            (base, 0o770, False),
            (base, 0o1777, True),
            (base, 0o755, True),
            (wanted, 0o1777, False),
            (wanted, 0o720, False),
        ]:
            whose.chmod(mode)
            folder, why_not = cache_folder()
            if fits:
                assert (folder, why_not) == (wanted, "")
            else:
                assert folder == temporary / f"pgimp-{os.geteuid()}" / wanted.name
                assert folder.stat().st_mode & 0o777 == 0o700
                assert f"cannot be trusted: others may write to it (mode {mode:04o})" in why_not
            whose.chmod(0o700)
        shutil.rmtree(base)
        base.mkdir(mode=0o700)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
def test_what_another_user_has_is_not_used(one_file, tmp_path, monkeypatch):
    os.chown(one_file, 12345, 12345)
    assert answer(one_file.parent) == (5.0, False)
    assert "it belongs to another user (uid 12345)" in messages()[0]
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("PGIMP_CACHE_DIR", str(tmp_path / "base"))
    wanted = cache_folder().path
    for path in (wanted.parent, wanted):
        os.chown(path, 12345, 12345)
        assert "it belongs to another user (uid 12345)" in cache_folder().why_not
        os.chown(path, 0, 0)


def test_the_cache_folder_is_absolute(tmp_path, monkeypatch):
    """So that it stays where it is when a program changes its folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for given, found in {"here": tmp_path / "here", "~/there": tmp_path / "home/there"}.items():
        monkeypatch.setenv("PGIMP_CACHE_DIR", given)
        assert preferred_folder().parent == found


def test_a_temporary_folder_that_others_can_write_to_is_not_used(tmp_path, monkeypatch):
    """What is in there is executed."""
    (tmp_path / "file").write_text("a folder cannot be made here")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("PGIMP_CACHE_DIR", str(tmp_path / "file"))
    usual = tmp_path / f"pgimp-{os.getuid()}"
    assert cache_folder().path.parent == usual
    assert usual.stat().st_mode & 0o777 == 0o700
    usual.chmod(0o777)
    assert cache_folder().path.parent != usual
    shutil.rmtree(usual)
    usual.symlink_to(tmp_path)
    assert cache_folder().path.parent != usual
