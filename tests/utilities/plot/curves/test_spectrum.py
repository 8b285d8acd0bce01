"""``pgimp plot --fft``: amplitudes and frequencies that are known, of any time steps."""

import re
from pathlib import Path

import numpy as np
import pytest
from plotted import invented, numbers, table

import pgimp
from pgimp.mpi.comm import Serial
from pgimp.utilities.plot.curves.spectrum import spectrum

RUNS = ("plates",)

#: Frequencies and amplitudes.
TONES = ((3.37, 2.0), (9.81, 0.5))


def tones(time):
    """A sum of sinusoids on a drift."""
    waves = [a * np.sin(2 * np.pi * f * time + f) for f, a in TONES]
    return np.sum(waves, axis=0) + 40.0 - 7.0 * time


def steps(kind):
    """Times of lines over 5 time units, some forty in a period of the faster tone."""
    rng = np.random.default_rng(5)
    if kind == "even":
        return np.linspace(1.0, 6.0, 2000)
    if kind == "uneven":
        return 1.0 + 5.0 * np.cumsum(rng.uniform(0.5, 1.5, 2000)) / 2000.0
    return np.concatenate([np.linspace(1.0, 3.0, 500, endpoint=False), np.linspace(3.0, 6.0, 1500)])


@pytest.mark.parametrize("kind", ["even", "uneven", "two rates"])
def test_two_tones_have_their_amplitudes(kind):
    time = steps(kind)
    found = spectrum(time, tones(time))
    assert found.even == (kind == "even")
    for peak, tone in zip(found.peaks(5), TONES, strict=True):
        assert peak == pytest.approx(tone, rel=2e-3)
    assert found.amplitude[0] < 1e-12  # no mean is left


@pytest.mark.parametrize("values", [0.0, 3.0])
def test_what_does_not_move_has_no_peak(values):
    time = steps("even")
    assert spectrum(time, np.full(len(time), values) - values * time).peaks(5) == []


def write(runs, folder, time, **columns):
    """A run whose history has these columns."""
    lines = {"time": time.tolist(), "step": [*range(len(time))]}
    invented(runs, folder, "tones", **lines, **{k: v.tolist() for k, v in columns.items()})


def test_the_command_writes_peaks_and_a_table(runs, plot, tmp_path):
    time = steps("even")
    still = np.full(len(time), 2.0)
    write(runs, tmp_path, time, **{"gauge.pool.height": tones(time), "mass": still})
    words = ("--fft", "--columns", "gauge.pool.height,mass")
    status, said, _ = plot("tones.out", *words, "--frequencies", "0,20", "--csv", "a.csv")
    assert status == 0 and (tmp_path / "tones-history-spectrum.png").exists()
    peaks = re.findall(r"([\d.]+) Hz \(amplitude ([\d.]+)\)", said)
    np.testing.assert_allclose(np.array(peaks, float), TONES, rtol=2e-3)
    assert "peaks of mass: none; resolution 0.2 Hz" in said
    drawn = table(tmp_path / "a.csv")
    assert list(drawn) == ["run", "frequency", "gauge.pool.height", "mass"]
    f, a = numbers(drawn, "frequency"), numbers(drawn, "gauge.pool.height")
    assert 19.9 < f[-1] <= 20.0 and f[0] == 0.0
    for frequency, amplitude in TONES:
        there = abs(f - frequency) < 0.3
        assert a[there].max() == pytest.approx(amplitude, rel=2e-3)
    assert not numbers(drawn, "mass").any()


def test_times_that_count_and_uneven_lines_are_told(runs, plot, tmp_path):
    """The first tone is only there early, the second one only late; two lines are at one time."""
    time = np.sort(np.concatenate([steps("uneven"), [4.0, 4.0]]))
    early = np.where(time < 3.5, np.sin(2 * np.pi * 4.0 * time), np.sin(2 * np.pi * 6.0 * time))
    write(runs, tmp_path, time, **{"kinetic-energy": early})
    for between, frequency in (("1,3.5", 4.0), ("3.5,6", 6.0)):
        status, said, _ = plot("tones.out", "--fft", "--between", between, "-o", "a.svg")
        assert status == 0 and "resampled to even steps by cubics" in said
        (found,) = re.findall(r"([\d.]+) Hz \(amplitude", said)
        assert float(found) == pytest.approx(frequency, rel=2e-3)


def test_what_cannot_be_transformed_is_said(runs, plot, tmp_path):
    time = np.linspace(0.0, 1.0, 15)
    write(runs, tmp_path, time, mass=time)
    for words, text in (
        (("--fft", "--columns", "mass"), "needs 16 lines or more with values; there are 15"),
        (("--fft", "--x", "step"), "--fft is over time"),
        (("--fft", "--field", "velocity"), "--fft is for curves over time"),
        (("--between", "0,1"), "--between is for a spectrum: give --fft too"),
        (("--fft", "--frequencies", "5"), "--frequencies 5: two numbers"),
    ):
        status, _, wrong = plot("tones.out", *words)
        assert status == 2 and text in wrong, words


def test_a_bar_has_its_first_frequency(tmp_path, plot):
    """The exact one, c/(4 L) = 5 Hz; its momentum is a triangle's integral, 8 rho g L/pi^2."""
    case = pgimp.load(Path(pgimp.__file__).parents[1] / "cases" / "bar-vibration.yaml")
    pgimp.run(case, Serial(), tmp_path / "bar.out", quiet=True)
    status, said, _ = plot("bar.out", "--fft", "--columns", "momentum-x")
    assert status == 0
    frequency, amplitude = re.search(r"([\d.]+) Hz \(amplitude ([\d.]+)\)", said).groups()
    assert float(frequency) == pytest.approx(5.0, rel=1e-3)
    assert float(amplitude) == pytest.approx(8e3 * 9.81 / np.pi**2 / (10.0 * np.pi), rel=5e-3)
