"""Draw the tests of the friction damper as a fleet: ``python docs/images/fleet.py brfd_all.npz``; it takes minutes.

What is identified is kept beside the file, in ``brfd_fleet``: the same command goes on there.
"""

import sys
from pathlib import Path

from bristle.apps.study.fleet import identify_each
from bristle.apps.study.many_runs import fleet_parameters
from bristle.apps.study.report import apart, fleet_summary
from bristle.apps.study.store import runs_in

AXIS = Path(__file__).parents[2] / "examples" / "friction_damper" / "axis.toml"

file = Path(sys.argv[1])
folder = file.with_name("brfd_fleet")
identify_each([f"{file}::*"], folder, model="gap_slider+asymmetry", axis=AXIS, draws=20)
runs = runs_in(folder)
told = fleet_summary(runs, provenance={})["parameters"]
names = [name for name, entry in told.items() if entry["count"] > runs.count / 2]
figure = fleet_parameters(runs, names, {name: apart(runs.columns, name) for name in names})
figure.savefig(Path(__file__).with_suffix(".png"), dpi=130, facecolor="white")
