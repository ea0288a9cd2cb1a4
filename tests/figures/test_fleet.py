"""The parameters of a fleet: every interval lies inside its panel."""

import numpy as np
from tests.figures.gallery import fleet

from bristle.figures.many_runs import fleet_parameters


def test_no_interval_is_clipped():
    runs, names, apart = fleet(["F_C", "M"])
    runs.columns["F_C.upper"] = runs.columns["F_C"] + np.where(np.arange(20) == 12, 3.0, 0.3)
    figure = fleet_parameters(runs, names, apart)
    for name, axes in zip(names, figure.axes, strict=False):
        bottom, top = axes.get_ylim()
        drawn = np.isfinite(runs.columns[name]) & (np.arange(20) != 3)  # the one far away ends in an arrow
        assert bottom < np.min(runs.columns[f"{name}.lower"][drawn])
        assert top > np.max(runs.columns[f"{name}.upper"][drawn])
        assert top < runs.columns[name][3]
