"""What each file of tests costs: CPU time, also of the processes it starts, and compiled kernels.

A plugin of pytest, for `tests/conftest.py`. The dearest files are listed at the end of a run; what
each test took is in ``.pytest_cache/v/pgimp/costs``.
"""

import resource
from collections import Counter

import pytest
from numba.core import event

#: Files that are listed; CPU seconds, cold, from which one has to be marked as slow.
LISTED, LONG = 12, 60.0


class _Compiled(event.Listener):
    """Counts the kernels that this process has compiled, but not what they call."""

    def __init__(self):
        self.count = self._depth = 0

    def on_start(self, event):
        """Begin to compile a function."""
        self.count += self._depth == 0
        self._depth += 1

    def on_end(self, event):
        """End that."""
        self._depth -= 1


def cpu():
    """CPU seconds of this process, and of those that it has waited for."""
    return sum(
        used.ru_utime + used.ru_stime
        for used in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


class Costs:
    """Measures tests in the workers, and adds up files where these report to."""

    def __init__(self, cache):
        self._compiled, self._cache = _Compiled(), cache
        event.register("numba:compile", self._compiled)
        self._tests: dict[str, tuple[float, int]] = {}
        self._seconds, self._kernels = Counter(), Counter()
        self._marked: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Measure a test with its fixtures."""
        begin, compiled = cpu(), self._compiled.count
        item.user_properties.append(("before", (begin, compiled)))
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        """Note what a test has cost so far."""
        report = yield
        if call.when == "teardown":
            (begin, compiled) = dict(item.user_properties)["before"]
            cost = cpu() - begin, self._compiled.count - compiled
            report.user_properties.append(("cost", cost))
        return report

    def pytest_runtest_logreport(self, report):
        """Add up a file's costs."""
        file = report.nodeid.partition("::")[0]
        if "slow" in report.keywords:
            self._marked.add(file)
        if cost := dict(report.user_properties).get("cost"):
            self._tests[report.nodeid] = cost
            self._seconds[file] += cost[0]
            self._kernels[file] += cost[1]

    def pytest_terminal_summary(self, terminalreporter):
        """List the dearest files, and keep what tests took."""
        total, kernels = sum(self._seconds.values()), sum(self._kernels.values())
        if total < 60.0:
            return
        self._cache.set("pgimp/costs", self._tests)
        terminalreporter.section(
            f"{total / 60.0:.1f} minutes of CPU time, {kernels} kernels compiled in tests"
        )
        unmarked = [file for file in self._seconds if file not in self._marked]
        for file in unmarked:
            if self._seconds[file] > LONG:
                text = f"{file} takes {self._seconds[file]:.0f} s, and has no pytest.mark.slow"
                terminalreporter.write_line(text, yellow=True)
        for file, seconds in self._seconds.most_common(LISTED):
            terminalreporter.write_line(f"{seconds:6.0f} s {self._kernels[file]:4d}  {file}")
