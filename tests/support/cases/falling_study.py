"""A study of a bar that falls."""

GRAVITY, END, START = -2.0, 1.0, 8.0
FALLING = f"""
format: 1
dimensions: 1
grid: {{origin: [0.0], size: [12.0], cell: [1.0]}}
method: {{shape: gimp, particles-per-cell: [2]}}
time: {{end: {END}, step: 0.1}}
materials: {{bar: {{model: linear-1d, young: 1.0, density: 1.0}}}}
bodies: {{bar: {{material: bar, region: {{box: {{min: [7.0], max: [9.0]}}}}}}}}
gravity: [{GRAVITY}]
"""
# The third run has so stiff a material that its step is unstable, which the set-up finds.
STUDY = f"""
format: 1
title: A falling bar
case: cases/falling.yaml
sweep:
  - {{time.step: [0.1, 0.05, 0.02], materials.bar.young: [1.0, 1.0, 1.0e+6]}}
error: {{column: body.bar.centre-x, reference: {START + 0.5 * GRAVITY * END**2}}}
columns: [mass, {{column: kinetic-energy, at: max}}]
cost: [wall, particle-steps, core]
folder: results
plot: {{x: time.step}}
"""


def put(folder, text=STUDY):
    (folder / "cases").mkdir(parents=True, exist_ok=True)
    (folder / "cases" / "falling.yaml").write_text(FALLING)
    path = folder / "fall.yaml"
    path.write_text(text)
    return path
