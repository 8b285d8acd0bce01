"""A worker that runs blocks with pgimp, on any number of ranks; see `processes`."""

from statistics import median

from blocks import Timed, block, create, errors
from workers.processes import peak_memory, serve

from pgimp.mpi.comm import world


def main():
    """Answer `make`, `round` and `result`."""
    comm = world()
    blocks = {}

    def answer(do, name="", case=None, random=False, steps=0):
        if do == "make":
            create(block([4] * case["dimensions"]), comm, random)  # loads the kernels
            before = peak_memory()
            blocks[name] = Timed(create(case, comm, random), steps)
            return {"particles": blocks[name].sim.count, "memory": peak_memory() - before}
        one = blocks[name]
        if do == "round":
            one.round()
            return {"seconds": one.seconds[-1], "speed": one.speeds[-1]}
        velocity, stress = errors(one.sim)
        return {
            "speeds": one.speeds, "speed": median(one.speeds), "velocity": velocity,
            "stress": stress, "phases": one.phases,
        }  # fmt: skip

    serve(comm, answer)


if __name__ == "__main__":
    main()
