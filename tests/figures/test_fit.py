"""A fit and a prediction beside their log: signals close up, bands, residuals and their distribution."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.signal import lfilter
from tests.figures.gallery import PLAIN, F, T, X, fit, predicted

from bristle.figures import fit as figures
from bristle.figures.report_figure import FIGURES

WORDS = "Shaded: the 95 % band of the measurement."


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_a_prediction_is_drawn_around_the_largest_difference_in_its_band():
    result = predicted()
    result.effort = F.copy()
    result.effort[400] += 50.0
    near, _ = figures.prediction(result).axes
    x = lines(near)["measured"].get_xdata()
    assert x[0] < T[400] < x[-1]
    (band,) = near.collections
    corners, middle = band.get_paths()[0].vertices, lines(near)["model"]
    at = np.interp(corners[:, 0], middle.get_xdata(), middle.get_ydata())
    assert np.abs(corners[:, 1] - at).max() == pytest.approx(0.2, abs=0.02)


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
    assert np.all(figures.autocorrelation(np.arange(100.0), np.zeros(100))[0] == 0.0)


def test_a_first_order_process_decays_by_its_pole():
    noise = np.random.default_rng(1).normal(size=40_000)
    signal = lfilter([1.0], [1.0, -0.8], noise)
    correlation, _ = figures.autocorrelation(np.arange(signal.size, dtype=float), signal)
    assert correlation[:6] == pytest.approx(0.8 ** np.arange(6), abs=0.03)


def test_no_product_is_taken_across_a_gap():
    signal = np.random.default_rng(2).normal(size=500)
    signal -= signal.mean()
    t = np.arange(500.0)
    alone, _ = figures.autocorrelation(t, signal)
    twice, count = figures.autocorrelation(np.concatenate([t, 1000.0 + t]), np.concatenate([signal, -signal]))
    assert count == 1000
    assert twice == pytest.approx(alone, abs=1e-12)


@pytest.mark.parametrize(
    ("unknown", "first", "errors"),
    [
        ((), "Force [N]", ["Force error [mN]", "Position error [µm]"]),
        (("position_predicted",), "Force [N]", ["Force error [mN]"]),
        (("effort_predicted",), "Position [mm]", ["Position error [µm]"]),
    ],
)
def test_a_prediction_shows_the_predicted_signals(unknown, first, errors):
    result = predicted()
    vars(result).update(dict.fromkeys(unknown))
    assert figures.prediction(result).axes[0].get_ylabel() == first
    assert [axes.get_ylabel() for axes in figures.prediction_error(result).axes] == errors
    assert [FIGURES[name].applies(result, "translational") for name in ("fit.prediction", "fit.error")] == [True, True]
    result.effort_predicted = result.position_predicted = None
    assert not FIGURES["fit.prediction"].applies(result, "translational")


def test_the_error_of_a_position_is_measured_minus_predicted_in_the_band():
    result = predicted()
    result.position_half_width = np.full(T.size, 1e-4)
    *_, off = figures.prediction_error(result).axes
    (error,) = off.get_lines()
    assert error.get_ydata().max() == pytest.approx(1e6 * (0.01 * X).max(), rel=1e-3)
    assert np.sign(error.get_ydata()[20]) == np.sign(X[20])
    ends = off.collections[0].get_paths()[0].vertices[:, 1]
    assert (ends.min(), ends.max()) == pytest.approx((-100.0, 100.0))


@pytest.mark.parametrize("band", [None, np.full(T.size, 0.2)])
def test_a_caption_mentions_a_band_only_if_it_is_drawn(band):
    result = predicted()
    result.half_width = band
    assert (FIGURES["fit.prediction"].caption(result, "translational") == WORDS) == (band is not None)
