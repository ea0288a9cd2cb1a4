"""Draw the following error with and without the identified feedforward: ``python picture.py`` after the commands."""

from dataclasses import replace
from pathlib import Path

from bristle import figures, simulate
from bristle.files import read_experiment

FOLDER = Path(__file__).parent
SHOWN = ("none", "identified", "observer_feedforward")

whole = read_experiment(FOLDER / "compensated.toml")
result = simulate(
    replace(whole, variants=tuple(one for one in whole.variants if one.name in SHOWN))
)
figures.following_error(result).savefig(FOLDER / "following_error.png", dpi=100, facecolor="white")
