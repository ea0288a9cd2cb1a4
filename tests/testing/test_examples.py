"""The results that figures are tried with are those of an axis that is known, and each demand has its two sides."""

import numpy as np
import pytest

from bristle.figures import ReportFigure
from bristle.testing import figures
from bristle.testing.check import UnmetError
from bristle.testing.figures import EXAMPLES, _experiment, _study


def test_an_example_loop_runs_with_and_without_friction_feedforward():
    fed, plain = _experiment("rotational").variants
    assert (fed.name, plain.name, plain.feedforward.friction) == ("base", "uncompensated", None)
    assert fed.friction == fed.feedforward.friction == plain.friction
    assert (fed.friction.values["F_C"], fed.friction.values["F_v"], fed.plant.values["M"]) == (5.0, 80.0, 12.0)
    assert (fed.controller.values["k_p"], fed.controller.values["k_v"], fed.sensor.values["resolution"]) == (40.0, 2000.0, 1e-6)
    assert (fed.reference.values["amplitude"], fed.reference.values["frequency"]) == (0.01, 2.0)
    # Two periods after half of one in which it settles.
    assert (fed.run.duration, fed.run.sample_time, fed.run.settle) == (1.25, 1e-3, 0.25)


@pytest.mark.parametrize(("kind", "units"), [("translational", ["N", "m"]), ("rotational", ["N*m", "rad"])])
def test_runs_of_an_example_study_have_an_error_that_grows_with_friction(kind, units):
    runs = _study(kind)
    assert (runs.described["kind"], runs.described["runs"], runs.described["draws"]) == (kind, 40, 40)
    assert [runs.described["columns"][name]["unit"] for name in ("friction.F_C", "following_error.rms")] == units
    level, error = (np.asarray(runs.columns[name]) for name in ("friction.F_C", "following_error.rms"))
    assert error == pytest.approx(1e-6 * level)
    assert (np.mean(level), np.std(level)) == (pytest.approx(5.0, abs=0.25), pytest.approx(0.5, rel=0.3))
    assert set(runs.columns["status"]) == {"ok"}
    assert list(runs.columns["run"]) == list(range(40))


def test_an_example_comparison_has_a_log_with_twice_the_error(monkeypatch):
    monkeypatch.setattr(figures, "compare", lambda before, after: (before, after))
    ((before, none),), ((after, nothing),) = EXAMPLES["comparison"]("rotational")
    apart = [float(np.mean(np.abs(log.reference.values - log.position.values))) for log in (before, after)]
    assert apart == pytest.approx([2e-5, 1e-5], rel=0.01)
    assert (before.kind, after.kind, none, nothing) == ("rotational", "rotational", None, None)
    assert before.effort.values.tolist() != after.effort.values.tolist()


def test_a_figure_that_pyplot_keeps_is_closed(monkeypatch):
    from matplotlib import pyplot

    monkeypatch.setattr(figures, "example_facts", lambda kind, takes: {"log": kind})
    before = set(pyplot.get_fignums())
    parts = {"title": "Title", "caption": "A sentence.", "alternative": "lines", "takes": "log"}
    kept, returned = (figures._Trial(ReportFigure(name="mine", draw=draw, **parts)) for draw in (lambda log: pyplot.figure(), print))
    with pytest.raises(UnmetError, match="pyplot keeps the figure"):
        figures.nothing_left_open(kept)
    assert set(pyplot.get_fignums()) == before
    assert figures.nothing_left_open(returned).applies
