"""What each file of tests costs: CPU time, also of the processes it starts, and compiled kernels.

A plugin of pytest, for `tests/conftest.py`. The dearest files are listed at the end of a run; what
each test took is in ``.pytest_cache/v/pgimp/costs``. With ``--costs FILE`` it is also appended to a
table as tests end: CPU seconds, those of compiling in the test's own process, kernels, test.
"""

import csv
import resource
import time
from collections import Counter

import pytest
from numba.core import event

#: Files that are listed; CPU seconds, cold, from which one has to be marked as slow.
LISTED, LONG = 12, 60.0


class _Compiled(event.Listener):
    """Counts the kernels that this process has compiled, but not what they call; CPU seconds."""

    def __init__(self):
        self.count = self._depth = 0
        self.seconds = self._began = 0.0

    def on_start(self, event):
        """Begin to compile a function."""
        if self._depth == 0:
            self.count += 1
            self._began = time.process_time()
        self._depth += 1

    def on_end(self, event):
        """End that."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.process_time() - self._began


def cpu():
    """CPU seconds of this process, and of those that it has waited for."""
    return sum(
        used.ru_utime + used.ru_stime
        for used in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


class Costs:
    """Measures tests in the workers, and adds up files where these report to."""

    def __init__(self, cache, table):
        self._compiled, self._cache, self._table = _Compiled(), cache, table
        event.register("numba:compile", self._compiled)
        self._tests: dict[str, tuple[float, float, int]] = {}
        self._seconds, self._kernels = Counter(), Counter()
        self._marked: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        """Measure a test with its fixtures."""
        item.user_properties.append(("before", self._now()))
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        """Note what a test has cost so far."""
        report = yield
        if call.when == "teardown":
            before = dict(item.user_properties)["before"]
            cost = tuple(now - then for now, then in zip(self._now(), before, strict=True))
            report.user_properties.append(("cost", cost))
        return report

    def _now(self):
        return cpu(), self._compiled.seconds, self._compiled.count

    def pytest_runtest_logreport(self, report):
        """Add up a file's costs."""
        file = report.nodeid.partition("::")[0]
        if "slow" in report.keywords:
            self._marked.add(file)
        if cost := dict(report.user_properties).get("cost"):
            seconds, compiling, kernels = self._tests[report.nodeid] = cost
            self._seconds[file] += seconds
            self._kernels[file] += kernels
            if self._table:
                with open(self._table, "a", encoding="utf-8") as stream:
                    row = f"{seconds:.2f}", f"{compiling:.2f}", kernels, report.nodeid
                    csv.writer(stream).writerow(row)

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
