"""Beginnings of study files."""

HEAD = "format: 1\ncase: cases/falling.yaml\nerror: kinetic-energy\n"
SWEEP = "sweep:\n  - {time.step: [0.1, 0.05]}\n"
