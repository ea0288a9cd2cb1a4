"""Identify a friction model with standard errors from a log. The simulated axis of `bristle demo` writes the log first."""

import tempfile
from pathlib import Path

import bristle as br
from bristle.cli.demonstration import axis_simulated
from bristle.prediction import drive_table

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "log.csv"
    axis_simulated.write_log(file, seed=1)
    axis = br.read_axis(axis_simulated.AXIS_FILE)
    found = br.identify(br.read_log(file, axis), "coulomb_viscous,lugre+asymmetry", axis=axis)

for fit in found.fits:
    print(f"{fit.rank}. {fit.name}: {fit.held_out.mean_percent:.2f} % held-out error")
for name, one in found.best.parameters.items():
    if one.status == "identified":
        print(
            f"  {name} = {one.value:.5g} {one.unit}, ± {one.relative_std_percent:.2f} % (standard error)"
        )
velocity, force = drive_table(found.best, 20)[-1]
print(f"last entry of the drive table: {velocity:.4f} m/s, {force:.2f} N")
