"""Draw the picture of the README, a figure of the report of ``bristle demo``: ``python docs/images/friction.py``."""

import tempfile
from pathlib import Path

from bristle import figures
from bristle.cli.demonstration import run
from bristle.files.results import results_folder
from bristle.prediction import drive_table

with tempfile.TemporaryDirectory() as place, results_folder(Path(place) / "demo") as folder:
    best = run(folder, command="bristle demo").identification.best

picture = figures.friction_over_velocity(best, drive_table(best, 200))
picture.savefig(Path(__file__).with_suffix(".png"), dpi=120, facecolor="white")
