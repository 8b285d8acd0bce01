"""ParaView's server on two processes, each of which reads its parts of a frame."""

import os
import signal
import socket
import subprocess

import numpy as np
import pytest
from particle_source import write_frames
from processes import PROGRAMS, clean_env

from pgimp.io.frames import vtkhdf
from pgimp.io.results.reader import Frame
from pgimp.mpi.comm import Serial


@pytest.fixture
def pvserver(display):
    """The port of a server on two processes that waits for a client, and ends with it."""
    with socket.socket() as free:
        free.bind(("", 0))
        port = free.getsockname()[1]
    words = ["mpirun", "-q", "--oversubscribe", "-n", "2", "pvserver", f"--server-port={port}"]
    server = subprocess.Popen(
        words,
        env=clean_env(display),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    for line in server.stdout:
        if line.startswith("Accepting connection"):
            break
    else:
        pytest.fail("pvserver did not start")
    yield port
    try:
        server.communicate(timeout=10)
    except subprocess.TimeoutExpired:
        os.killpg(server.pid, signal.SIGKILL)
        server.communicate()


def test_two_processes_share_the_parts(monkeypatch, tmp_path, pvserver, pvpython):
    monkeypatch.setattr(vtkhdf, "PART", 10)
    write_frames(tmp_path, Serial(), 47, 3)
    path = tmp_path / "frames" / "particles-000001.h5"
    job = pvpython(PROGRAMS / "pvserver_probe.py", pvserver, path, tmp_path / "seen.npz")
    assert job.returncode == 0, job.stdout + job.stderr
    frame = Frame(path)
    with np.load(tmp_path / "seen.npz") as seen:
        ids = [seen["0/id"], seen["1/id"]]
        assert [len(own) for own in ids] == [27, 20]
        order = np.argsort(np.concatenate(ids))
        for name in frame.fields:
            both = np.concatenate([seen[f"0/{name}"], seen[f"1/{name}"]])[order]
            np.testing.assert_array_equal(both, frame[name], err_msg=name)
