"""A worker that runs blocks with Taichi, in an environment that has it; see `processes`.

Positions come from files, so that they are the same as pgimp's.
"""

import sys
from statistics import median

import numpy as np
from workers.processes import serve
from workers.taichi_kernels import Block, start


class Alone:
    """A communicator of one process."""

    rank, size = 0, 1


def main(threads):
    """Answer `version`, `make`, `round` and `result`."""
    taichi = start(threads)
    blocks = {}

    def answer(do, name="", steps=0, file="", method="", scene=None):
        if do == "version":
            return {"version": taichi}
        if do == "make":
            with np.load(file) as given:
                block = Block(method, given["x"], given["v"], **scene)
            blocks[name] = (block, [], steps)
            block.advance(1)  # compiles
            block.advance(steps)
            return {"particles": block.count}
        block, seconds, steps = blocks[name]
        if do == "round":
            seconds.append(block.advance(steps))
            return {"seconds": seconds[-1]}
        speeds = [block.count * steps / s / 1e6 for s in seconds]
        velocity, stress = block.errors(**scene)
        return {"speeds": speeds, "speed": median(speeds), "velocity": velocity, "stress": stress}

    serve(Alone, answer)


if __name__ == "__main__":
    main(int(sys.argv[1]))
