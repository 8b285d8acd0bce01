"""The cases in cases/, and what makes each coarser, or shorter, for its test."""

from pathlib import Path

CASES = Path(__file__).resolve().parents[3] / "cases"


COARSER = {
    "bar-vibration": [
        "grid.cell=[0.05]",
        "grid.size=[1.1]",
        "time.step=5.0e-4",
        "time.end=0.45",
        "output.every=0.05",
    ],
    "block3d": ["grid.cell=[0.2,0.2,0.2]", "time.end=0.7", "output.every=0.1"],
    "compaction": [
        "grid.cell=[2.5]",
        "grid.size=[55.0]",
        "method.particles_per_cell=[1]",
        "time.step=2.5e-4",
        "time.end=0.5",
        "history.every={steps: 100}",
    ],
    "shock": ["grid.cell=[2.0]", "time.step=2.5e-4", "output.at=[]"],
    "blast": ["grid.cell=[2.0e-3]"],
    "plate-impact": ["grid.cell=[2.0e-4]"],
    "taylor-bar": [
        "grid.cell=[1.6e-3,1.6e-3,1.6e-3]",
        "grid.size=[0.0336,0.0096,0.0096]",
        "output.every=4.0e-5",
    ],
    "taylor-axisymmetric": ["grid.cell=[8.0e-4,8.0e-4]", "output.every=4.0e-5"],
    "thick-tube": ["grid.cell=[0.2,0.2]"],
    "tube": ["grid.cell=[0.0625,0.0625]"],
    "vortex": ["grid.cell=[0.1,0.1]", "time.step=1.0e-2", "time.end=0.6", "output.every=0.3"],
    "spinning-block": [
        "grid.cell=[0.2,0.2,0.2]",
        "time.step=4.0e-3",
        "time.end=0.5",
        "output.every=0.25",
    ],
    "plane-waves": ["grid.cell=[0.03125,0.03125]", "time.step=2.5e-3", "output.every=0.25"],
    "disks": ["grid.cell=[0.04,0.04]", "output.every=0.5"],
    "incline": ["grid.cell=[0.1,0.1]", "time.end=0.6", "output.every=0.3"],
    "rolling": ["grid.cell=[0.05,0.05]", "time.end=0.5", "output.every=0.25"],
    "rolling-ball": ["grid.cell=[0.02,0.02,0.02]", "time.end=0.25", "output.every=0.05"],
    "upsetting": ["grid.cell=[0.05,0.05]", "output.every=0.4"],
    "pile": ["grid.cell=[0.2]"],
    "hertz": ["grid.cell=[0.02,0.02,0.02]", "output.every=0.04"],
    "hertz-line": ["grid.cell=[4.8e-3,4.8e-3]"],
    "corner": ["grid.cell=[0.05,0.05]", "gravity.table.1.0=0.4", "time.end=0.6"],
    "drum": ["grid.cell=[0.024,0.024]", "time.end=0.1", "history.every={steps: 10}"],
    "sod": ["grid.cell=[0.005]", "output.every=0.1"],
    "channel": ["output.every=0.25"],
    "sand-column": ["grid.cell=[0.04,0.04]", "time.end=0.75", "output.every=0.75"],
    "slope": ["grid.cell=[0.2,0.2]", "output.every=0.5"],
    "excavation": ["grid.cell=[0.2,0.2]", "output.every=0.5"],
    "safety": ["grid.cell=[1.25,1.25]", "output.every=1.5"],
    "footing": [
        "grid.cell=[0.2,0.2]",
        "grid.size=[4.0,2.6]",
        "bodies.strip.region.box.max=[1.1,3.0]",
        "time.end=0.4",
        "output.every=0.4",
    ],
    "graded": ["grid.cell=[1.0]", "output.every=11.0", "history.every=1.0"],
    "gate": ["grid.cell=[0.005,0.01]", "time.end=0.02", "output.every=0.01"],
    "hopper": ["time.end=1.1", "output.every=0.55"],
    "jet": ["grid.cell=[0.025,0.025]", "output.every=0.5"],
    "dam-break": ["grid.cell=[0.07,0.06]", "time.end=1.0", "output.every=0.5"],
}
