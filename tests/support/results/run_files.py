"""Files of whole runs: what they hold, and runs that go on from an earlier checkpoint."""

import hashlib


def go_back(run, part):
    """Delete all checkpoints after a part of a run, as if it had been killed before the next."""
    checkpoints = sorted((run / "checkpoints").iterdir())
    assert len(checkpoints) > 2
    for path in checkpoints[1 + int(part * (len(checkpoints) - 2)) :]:
        path.unlink()
    info = run / "run.json"
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))


def digests(run):
    """Of all frames and the files that list them, of the history and of the probes."""
    files = [*sorted((run / "frames").iterdir()), run / "history.csv"]
    files += [*run.glob("probes/*"), *run.glob("*.xdmf"), *run.glob("*.vtkhdf")]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
