"""A fit and a prediction beside their log: branches of friction, signals close up, bands, residuals and their distribution."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.figures.gallery import PLAIN, F, T, X, fit, predicted

from bristle.figures import fit as figures

WORDS = "The shading is the 95 % band of the measurement."


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def pair(half_width=None):
    figure = Figure()
    full, close = figure.subplots(2, 1)
    effort = F.copy()
    effort[400] += 50.0
    figures.draw_pair(full, close, T, effort, F, "translational", half_width)
    return full, close


def test_the_close_up_is_around_the_largest_difference_and_shaded_above():
    full, close = pair()
    (shade,) = full.patches
    low, high = (float(edge) for edge in (shade.get_x(), shade.get_x() + shade.get_width()))
    assert low < T[400] < high
    assert high - low == pytest.approx(T[39])
    assert lines(close)["measured"].get_xdata()[[0, -1]] == pytest.approx([low, high])
    assert not close.patches
    assert not full.collections


def test_a_band_lies_by_the_half_width_around_the_prediction():
    full, close = pair(np.full(T.size, 2.0))
    for axes in (full, close):
        (band,) = axes.collections
        corners = band.get_paths()[0].vertices
        middle = lines(axes)["predicted"]
        at = np.interp(corners[:, 0], middle.get_xdata(), middle.get_ydata())
        assert np.abs(corners[:, 1] - at).max() == pytest.approx(2.0, abs=0.2)
        assert band.get_label() == "95 % band"


def test_a_band_with_a_gap_has_a_single_name():
    axes, x = Figure().add_subplot(), np.array([0.0, 1.0, 2.0, 8.0, 9.0])
    figures.draw_band(axes, x, np.zeros(5), np.ones(5))
    assert [band.get_label() for band in axes.collections] == ["95 % band", "_95 % band"]
    assert [band.get_paths()[0].vertices[:, 0].max() for band in axes.collections] == [2.0, 9.0]
    assert {float(end) for end in axes.collections[0].get_paths()[0].vertices[:, 1]} == {-1.0, 1.0}


def with_residual(residual):
    best = fit(PLAIN, "lugre")
    best.traces.residual, best.traces.time = residual, 5e-3 * np.arange(residual.size)
    return figures.residuals(best)


def test_the_distribution_of_residuals_is_drawn_with_a_normal_distribution():
    residual = 3.0 + 0.5 * np.random.default_rng(3).normal(size=4000)
    over_time, spread, white = with_residual(residual).axes
    shares, edges, _ = spread.patches[0].get_data()
    assert shares.size == 40
    assert (edges[0], edges[-1]) == pytest.approx((residual.mean() - 4.0 * residual.std(), residual.mean() + 4.0 * residual.std()))
    assert shares.sum() == pytest.approx(100.0, abs=0.1)
    normal, at = lines(spread)["normal"].get_data()
    assert normal == pytest.approx(np.interp(at, 0.5 * (edges[1:] + edges[:-1]), shares), abs=1.5)
    assert at[normal.argmax()] == pytest.approx(residual.mean(), abs=0.05)
    assert spread.get_ylim() == over_time.get_ylim()
    assert over_time.get_ylabel() == "Residual [N]"
    assert white.get_xlabel() == "Lag [ms]"
    assert [float(bar.vertices[0, 0]) for bar in white.collections[0].get_paths()[:3]] == pytest.approx([0.0, 5.0, 10.0])


def test_the_band_of_white_noise_contains_95_percent():
    *_, white = with_residual(np.random.default_rng(4).normal(size=2500)).axes
    box = white.patches[0].get_patch_transform().transform_path(white.patches[0].get_path()).vertices[:, 1]
    assert (box.min(), box.max()) == pytest.approx((-1.96 / 50.0, 1.96 / 50.0), rel=1e-3)
    assert white.get_ylim() == (-0.3, 1.05)
    alternating = with_residual(np.tile([1.0, -1.0], 500)).axes[2]
    assert alternating.get_ylim()[0] == pytest.approx(-1.05, abs=0.01)


def test_zero_residuals_have_no_normal_distribution():
    _, spread, _ = with_residual(np.zeros(500)).axes
    assert not lines(spread)
    assert spread.patches[0].get_data()[1][[0, -1]].tolist() == [-1.0, 1.0]


def test_no_lag_is_longer_than_the_longest_stretch():
    correlation, count = figures.autocorrelation(np.arange(5.0), np.array([1.0, -1.0, 1.0, -1.0, 1.0]))
    assert (correlation.size, count) == (5, 5)
    assert figures.autocorrelation(np.arange(100.0), np.sin(np.arange(100.0)))[0].size == 61
    assert figures.autocorrelation(np.arange(3.0), np.full(3, np.nan))[0].size == 1


@pytest.mark.parametrize(("effort", "position", "panels"), [(True, True, 4), (True, False, 2), (False, True, 2)])
def test_a_prediction_shows_the_predicted_signals(effort, position, panels):
    result = predicted()
    if not effort:
        result.effort_predicted = None
    if not position:
        result.position_predicted = None
    figure = figures.prediction(result)
    assert len(figure.axes) == panels
    assert figure.get_size_inches()[1] == pytest.approx(0.5 + 1.6 * panels)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["Force [N]"] * (2 * effort) + ["Position [mm]", "Position error [µm]"] * position
    assert figures.PREDICTION.applies(result, "translational")
    result.effort_predicted = result.position_predicted = None
    assert not figures.PREDICTION.applies(result, "translational")


def test_the_error_of_a_position_is_measured_minus_predicted_in_the_band():
    result = predicted()
    result.position_half_width = np.full(T.size, 1e-4)
    *_, course, off = figures.prediction(result).axes
    (error,) = (line for line in off.get_lines() if line.get_label().startswith("_"))
    assert error.get_ydata().max() == pytest.approx(1e6 * (0.01 * X).max(), rel=1e-3)
    assert np.sign(error.get_ydata()[20]) == np.sign(X[20])
    ends = off.collections[0].get_paths()[0].vertices[:, 1]
    assert (ends.min(), ends.max()) == pytest.approx((-100.0, 100.0))
    corners = course.collections[0].get_paths()[0].vertices
    assert corners[:, 1].max() == pytest.approx(1e3 * (0.99 * X.max() + 1e-4), rel=1e-3)
    assert corners[:, 0].max() == pytest.approx(T[-1])


@pytest.mark.parametrize(("effort", "position"), [(None, None), (1, None), (None, 1)])
def test_a_caption_mentions_a_band_only_if_it_is_drawn(effort, position):
    result = Some(half_width=effort, position_half_width=position, mode="inverse")
    assert (WORDS in figures.PREDICTION.caption(result, "translational")) == (effort is not None or position is not None)
    assert "inverse mode: " in figures.PREDICTION.caption(result, "translational")
