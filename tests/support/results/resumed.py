"""How often runs that are resumed keep checkpoints, what they leave, and whether it is the same."""

from pgimp.running.checkpoints import number_of, present

EVERY = "checkpoint={every: {steps: 40}, keep: 3}"


def check_same(one, other):
    for name in ("history.csv", "particles.xdmf", "particles.vtkhdf", "case.yaml"):
        assert (one.path / name).read_bytes() == (other.path / name).read_bytes()
    for mine, theirs in zip(one, other, strict=True):
        assert mine.path.read_bytes() == theirs.path.read_bytes()


def steps(run):
    return [number_of(path) for path in present(run.path / "checkpoints")]
