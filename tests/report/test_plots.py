"""The script of the plots: its scales are those of matplotlib, and its marks are round."""

import json
import subprocess
from importlib import resources

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.lab.scripts import NODE, needs_node


def computed(folder, expression):
    """Return a value of the functions of the script that need no page."""
    text = resources.files("bristle.report").joinpath("templates", "plots.js").read_text(encoding="utf-8")
    file = folder / "plots.js"
    file.write_text(f"{text[: text.index('class Plot {')]}\nconsole.log(JSON.stringify({expression}));\n", encoding="utf-8")
    return json.loads(subprocess.run([NODE, str(file)], capture_output=True, text=True, check=True).stdout)


@needs_node
@pytest.mark.parametrize(
    ("scale", "ends", "values"),
    [
        ("linear", (-3.0, 7.0), (-3.0, 0.0, 6.5)),
        ("log", (0.01, 100.0), (0.02, 1.0, 70.0)),
        ("symlog", (-200.0, 50.0), (-150.0, -2.0, -0.5, 0.0, 1.0, 1.5, 30.0)),
    ],
)
def test_a_value_lies_where_matplotlib_draws_it(scale, ends, values, tmp_path):
    axes = Figure().add_subplot()
    axes.set_xscale(scale, **({"linthresh": 1.0, "linscale": 1.0} if scale == "symlog" else {}))
    axes.set_xlim(*ends)
    drawn = axes.transAxes.inverted().transform(axes.transData.transform([[value, 0.5] for value in values]))[:, 0]
    side = json.dumps({"ends": ends, "scale": scale, "linear": 1.0})
    shares = computed(tmp_path, f"{json.dumps(values)}.map(scaleOfSide({side}).at)")
    assert shares == pytest.approx(drawn.tolist(), abs=1e-9)
    back = computed(tmp_path, f"{json.dumps(shares)}.map(scaleOfSide({side}).value)")
    assert back == pytest.approx(list(values), abs=1e-9)


@needs_node
def test_marks_are_round_and_inside(tmp_path):
    assert computed(tmp_path, "ticksBetween(-0.13, 0.62, 4, true)") == [0.0, 0.2, 0.4, 0.6]
    assert computed(tmp_path, "ticksBetween(0.5, 200, 4, false)") == [1, 10, 100]
    assert computed(tmp_path, "ticksBetween(-20, 0.5, 4, false)")[:2] == [-10, -1]
    assert np.array(computed(tmp_path, "ticksBetween(18.7, 19.9, 8, true)")) == pytest.approx([18.8, 19.0, 19.2, 19.4, 19.6, 19.8])
