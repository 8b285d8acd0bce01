"""When slab boundaries move: decisions of a balance on a machine that is made up."""

import numpy as np
import pytest

from pgimp.decomposition import balance as balance_module
from pgimp.decomposition.balance import Balance
from pgimp.decomposition.slabs import cut, imbalance_of
from pgimp.errors import UsageError


class Machine:
    """Ranks on which a particle and a plane take some time; only rank 0 is there."""

    rank = 0

    def __init__(self, layers, ranks, speed=None):
        self.layers, self.size = np.array(layers), ranks
        self.speed = np.ones(ranks) if speed is None else np.array(speed)
        self.cost = np.ones(len(layers))  # of a particle there
        self.balance = Balance(cut(self.layers, ranks, 2), self.layers.sum(), 3, 0, 48)
        self.step = 0
        self.move_seconds = 0.0
        self.rng = np.random.default_rng(7)

    def Allgather(self, mine, every):
        every[:] = self.every

    def run(self, intervals=1, noise=0.0, plane=0.0):
        """Steps, a report every 48, and a decision where it is asked for; how often it moved."""
        before = len(self.balance.moves)
        for _ in range(intervals):
            self.step += 48
            cuts = self.balance.cuts
            counts = np.add.reduceat(self.layers, cuts[:-1])
            weight = np.add.reduceat(self.layers * self.cost, cuts[:-1])
            planes = np.diff(cuts)
            random = 1.0 + noise * self.rng.exponential(size=self.size)
            seconds = 1e-6 * weight / self.speed * random
            moved = np.full(self.size, self.move_seconds)
            self.every = np.stack([seconds, plane * planes, counts, planes, moved], axis=1)
            self.seconds = seconds + plane * planes
            self.balance.report(self, int(counts[0]), int(planes[0]), self.step)
            if self.balance.rebalance_requested:
                new = self.balance.decide(self.layers, self.step)
                if new:
                    self.balance.cuts = new
                    self.balance.moved(0.0, self.step)
                self.balance.watch(0)
        return len(self.balance.moves) - before

    def imbalance(self):
        return self.seconds.max() / self.seconds.mean() - 1.0


def body(layers=400, first=0, end=400, each=1000):
    counts = np.zeros(layers, int)
    counts[first:end] = each
    return counts


def test_what_is_balanced_stays():
    assert Machine(body(), 4).run(50) == 0


def test_a_body_that_spreads_is_followed():
    machine = Machine(body(end=100), 4)
    for end in range(100, 400):
        machine.layers = body(end=end, each=100000 // end)
        machine.run()
        assert machine.imbalance() < 0.1
    machine.run()
    assert 10 < len(machine.balance.moves) < 150
    assert machine.imbalance() < 0.05
    before, after = np.array(machine.balance.moves).T
    assert (after < before).all() and after.max() < 0.05


@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_noise_moves_nothing(noise):
    assert Machine(body(), 8).run(300, noise) <= 2


def test_a_rank_that_was_interrupted_moves_nothing():
    machine = Machine(body(), 4)
    for _ in range(20):
        machine.run(7)
        machine.speed[2] = 0.2
        machine.run()
        machine.speed[2] = 1.0
    assert not machine.balance.moves


def test_a_core_that_is_disturbed_for_tenths_of_a_second_moves_nothing():
    """Steps of a millisecond: eight intervals in a row, 0.4 s, are slow on one rank."""
    machine = Machine(body(each=10), 4)
    for _ in range(20):
        machine.run(20, 0.02)
        machine.speed[2] = 0.8
        machine.run(8, 0.02)
        machine.speed[2] = 1.0
    assert not machine.balance.moves
    machine.speed[2] = 0.8  # for good
    assert machine.run(60, 0.02) >= 1


def test_a_slow_rank_gets_less_and_a_heavy_body_more_ranks():
    """Both in a few moves, after a while, and then all is quiet."""
    slow = Machine(body(), 4, speed=[1.0, 1.0, 0.5, 1.0])
    heavy = Machine(body(), 4)
    heavy.cost[:100] = 3.0
    for machine in (slow, heavy):
        assert machine.run(3, 0.02) == 0
        moves = machine.run(80, 0.02)
        assert 1 <= moves <= 8
        machine.run(1)
        assert machine.imbalance() < 0.06
        assert machine.run(100, 0.02) <= 1


def test_planes_cost_something_too():
    """Few particles in wide planes, where a plane takes as long as a thousand particles."""
    counts = np.concatenate([body(100, 0, 100, 3000), body(300, 0, 300, 200)])
    machine = Machine(counts, 4)
    assert imbalance_of(counts, machine.balance.cuts) < 0.05
    machine.run(3, plane=1e-3)
    assert machine.imbalance() < 0.05


def test_a_move_must_pay():
    """One that takes as long as a thousand steps does not, for a gain of a few per cent."""
    machine = Machine(body(), 4)
    machine.balance.cuts = [0, 110, 200, 300, 400]
    machine.balance.move_cost = 3000.0
    assert machine.run(10) == 0
    machine = Machine(body(), 4)
    machine.balance.cuts = [0, 110, 200, 300, 400]
    assert machine.run(10) == 1


def test_a_rank_asks_when_particles_pour_in():
    balance = Balance([0, 50, 100], 1000, 3, 0, 48)
    timings = dict.fromkeys(("P2G", "G2P", "order", "momentum"), 0.0)
    balance.watch(500)
    balance.note(timings, 500, 1)
    balance.note(timings, 514, 900)
    assert not balance.rebalance_requested
    balance.note(timings, 530, 900)
    assert balance.rebalance_requested


def test_a_rank_asks_for_nothing_that_cannot_pay():
    """A decision alone takes as long as some steps of a small scene."""
    balance = Balance([0, 50, 100], 1000, 3, 0, 48)
    timings = dict.fromkeys(("P2G", "G2P", "order", "momentum"), 0.0)
    balance.watch(500)
    for step in range(1, 2000):
        balance.note(timings, 530, step)
        if balance.rebalance_requested:
            break
    move_cost = balance_module._MOVE_COST * (30 + balance_module._FIXED_COST)
    assert 30 * (step - 1) <= move_cost < 30 * step
    balance.moved(0.0, step)
    balance.watch(530)
    balance.note(timings, 560, step + 1)
    assert not balance.rebalance_requested


def test_the_switch(monkeypatch):
    assert Balance([0, 50, 100], 1000, 3, 0, 48).on
    assert not Balance([0, 100], 1000, 3, 0, 48).on
    monkeypatch.setenv("PGIMP_BALANCE", "0")
    assert not Balance([0, 50, 100], 1000, 3, 0, 48).on
    monkeypatch.setenv("PGIMP_BALANCE", "no")
    with pytest.raises(UsageError, match="PGIMP_BALANCE is 'no'; 0 keeps"):
        Balance([0, 50, 100], 1000, 3, 0, 48)
