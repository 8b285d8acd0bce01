"""The rate of controlled steps: it rises at once and falls rarely.

Steps that become longer and shorter with the strain of a vibration feed it. Its energy, bounded
with steps of one length, then grows by about a percent a period, with any transfer. So a rate is
held until a whole window of steps in a row would have allowed a lower one. A rate that rises again
soon after shows that the window was shorter than the vibration; the window is then doubled.
"""

#: Steps of the first window, and of the longest.
FIRST, LONGEST = 64, 512

#: Least gain of lengthening, relative to the step.
WORTH = 0.05

#: This times the gain shortens a window, if it is above 1: the end of a spike is no vibration.
EAGER = 4.0


class HeldRate:
    """The greatest rate of a window of steps, or an earlier greater one.

    Attributes
    ----------
    rate : float
        The rate of the steps, at least the current one; 0 before the first.
    window : int
        Steps that must allow a lower rate before it is taken.
    lengthened, waited : int
        Number of reductions of the rate, and of steps that would have allowed a lower one.
    """

    def __init__(self) -> None:
        self.rate = self._most = self._low = 0.0
        self._count, self.window, self.lengthened, self.waited = 0, FIRST, 0, 0

    @property
    def numbers(self) -> list[float]:
        """The state for a checkpoint."""
        whole = (self._count, self.window, self.lengthened, self.waited)
        return [self.rate, self._most, self._low, *map(float, whole)]

    @numbers.setter
    def numbers(self, numbers: list[float]) -> None:
        self.rate, self._most, self._low = numbers[:3]
        self._count, self.window, self.lengthened, self.waited = map(int, numbers[3:])

    def follow(self, rate: float) -> float:
        """Return the rate for the next step, given the largest (c + |v|)/L; once a step."""
        if not rate <= self.rate:  # also where it is not a number
            self.rate = rate
        if self._low and rate > (1.0 + WORTH) * self._low:  # it was lowered too early
            self.window, self._low = min(2 * self.window, LONGEST), 0.0
        if rate * (1.0 + WORTH) > self.rate:  # the window begins again
            self._count, self._most = 0, 0.0
            return self.rate
        self._most = max(self._most, rate)
        self._count += 1
        self.waited += 1
        # A step that is far too short is no vibration's: it need not be kept as long.
        gain = EAGER * (self.rate - self._most)
        if self._count * max(self._most, gain) >= self.window * self._most:
            self.rate = self._low = self._most
            self.lengthened += 1
            self._count, self._most = 0, 0.0
        return self.rate
