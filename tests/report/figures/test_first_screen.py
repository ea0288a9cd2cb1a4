"""The pictures of the first screen: gain at the worst reversal, friction over velocity and over displacement, effort."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.signal import lfilter
from tests.report.figures.gallery import PLAIN, F, T, V, X, fit, lines, looped, predicted

from bristle.report.figures import first_screen as figures, fit as fit_module, report_figure

NAMES = ("base", "plain", "fed")


def named_lines(axes):
    return {label: line for label, line in lines(axes).items() if not label.startswith("_")}


@pytest.mark.parametrize(
    ("names", "pair", "size", "drawn"),
    [
        (NAMES, NAMES[1:], 1e-6, ["measured", "without", "with friction"]),
        (NAMES, NAMES[1:], 1.0, ["without", "with friction"]),  # it would flatten the others
        (
            ("measured", "plain", "fed"),
            ("measured", "fed"),
            1e-6,
            ["measured", "without", "with friction"],
        ),
    ],
)
def test_a_measured_error_is_drawn_unless_it_would_flatten_the_others(names, pair, size, drawn):
    assert (
        list(
            named_lines(
                figures.gain_at_reversal(looped(names), pair, size * np.sin(9.0 * T)).axes[0]
            )
        )
        == drawn
    )


def boxes_of(figure, texts):
    """Where texts are once a figure is drawn, from below."""
    figure.canvas.draw()
    return sorted((text.get_window_extent() for text in texts), key=lambda box: box.y0)


def test_lines_carry_their_names_apart_from_each_other():
    figure = figures.gain_at_reversal(looped(NAMES), NAMES[1:], 1e-6 * np.sin(9.0 * T))
    boxes = boxes_of(
        figure,
        [
            text
            for text in figure.axes[0].texts
            if text.get_text() in ("measured", "without", "with friction")
        ],
    )
    assert len(boxes) == 3
    assert all(low.y1 <= high.y0 + 1.0 for low, high in pairwise(boxes))
    assert all(box.x0 >= 0.0 and box.x1 <= figure.bbox.x1 for box in boxes)


def test_friction_over_velocity_is_linear_near_zero_and_logarithmic_beyond():
    best = fit(PLAIN, "lugre")
    best.traces.velocity = np.array([-0.2, -1e-3, 1e-3, 0.2])
    best.traces.friction = np.array([-4.0, -3.0, 1.0, 5.0])
    (axes,) = figures.friction_over_velocity(
        best, [(-0.2, -6.0), (-0.0, -5.0), (0.0, 5.0), (0.2, 6.0)]
    ).axes
    assert named_lines(axes)["measured"].get_data() == (
        pytest.approx([-200.0, -1.0, 1.0, 200.0]),
        pytest.approx([-4.0, -3.0, 1.0, 5.0]),
    )
    # At the right end, where its name is.
    assert named_lines(axes)["model"].get_ydata() == pytest.approx([5.0, 6.0])
    assert [
        line.get_ydata().tolist() for line in axes.get_lines() if line.get_label() == "_same"
    ] == [[-6.0, -5.0]]
    assert (axes.get_xscale(), axes.get_xlabel(), axes.get_ylabel()) == (
        "symlog",
        "Velocity [mm/s]",
        "Friction force [N]",
    )
    assert [label.get_text() for label in axes.get_xticklabels()] == [
        "−100",
        "−10",
        "0",
        "10",
        "100",
    ]


def test_the_band_of_the_model_contains_its_curve_on_both_sides():
    curve = [(-0.2, -6.0), (-0.1, -5.0), (0.1, 5.0), (0.2, 6.0)]
    (axes,) = figures.friction_over_velocity(fit(PLAIN, "lugre"), curve, [1.0, 0.5, 0.25, 2.0]).axes
    shaded = [band.get_datalim(axes.transData) for band in axes.collections]
    assert [(band.y0, band.y1) for band in shaded] == [
        pytest.approx((-7.0, -4.5)),
        pytest.approx((4.0, 8.0)),
    ]
    assert [(band.x0, band.x1) for band in shaded] == [
        pytest.approx((-200.0, -100.0)),
        pytest.approx((100.0, 200.0)),
    ]
    assert not figures.friction_over_velocity(fit(PLAIN, "lugre"), curve).axes[0].collections


@pytest.mark.parametrize(
    ("measured", "modelled", "labels"),
    [
        ((2e-3, 0.02), (5e-3, 0.05), ("Velocity [mm/s]", "Friction force [mN]")),
        ((2e-3, 0.02), (5e-3, 5.0), ("Velocity [mm/s]", "Friction force [N]")),
        ((2e-3, 5.0), (5e-6, 0.05), ("Velocity [mm/s]", "Friction force [N]")),
        ((2e-6, 0.02), (5e-6, 0.05), ("Velocity [µm/s]", "Friction force [mN]")),
    ],
)
def test_units_are_those_of_the_larger_of_measured_and_modelled(measured, modelled, labels):
    best = fit(PLAIN, "lugre")
    best.traces.velocity, best.traces.friction = (np.array([-value, value]) for value in measured)
    (axes,) = figures.friction_over_velocity(best, [modelled]).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels


def test_reversals_begin_after_a_motion_in_the_other_direction_or_a_rest():
    velocity = np.array([0.0, 1.0, 1.0, 1.0, -2.0, -2.0, -2.0, 0.0, 0.0, 3.0, 3.0, 3.0, 3.0])
    motions = figures.reversals_of(np.arange(13.0), velocity)
    assert [(motion.rows, motion.way) for motion in motions] == [
        (slice(9, 13), 1.0),
        (slice(4, 7), -1.0),
        (slice(1, 4), 1.0),
    ]
    assert motions[0].displacement.tolist() == [3.0, 6.0, 9.0, 12.0]
    # A gap in time is no reversal, and a tiny motion is left out.
    assert (
        figures.reversals_of(
            np.array([0.0, 1.0, 2.0, 9.0, 10.0, 11.0]), np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
        )
        == []
    )
    tiny = np.concatenate([np.full(3, -1e-3), np.full(50, 1.0)])
    assert [motion.way for motion in figures.reversals_of(np.arange(53.0), tiny)] == [1.0]


def test_friction_after_reversals_is_in_the_direction_of_motion_over_the_distance():
    best = fit(PLAIN, "lugre")
    best.traces.residual = 0.5 * np.ones(T.size)
    figure, large = (
        figures.friction_after_reversals(best, 1e-4),
        figures.friction_after_reversals(best, 0.0, large=True),
    )
    (axes,) = figure.axes
    x, y = named_lines(axes)["measured"].get_data()
    assert axes.get_xlim() == pytest.approx((0.0, 400.0))
    runs = np.split(y, np.flatnonzero(np.isnan(y)))
    # Friction acts against both directions.
    assert all(np.nanmax(run) > 0.0 for run in runs if np.isfinite(run).any())
    first = next(
        motion
        for motion in figures.reversals_of(T, V)
        if np.any(np.isclose(1e6 * motion.displacement[0], x[0]))
    )
    assert y[0] == pytest.approx(first.way * F[first.rows][0])
    gaps = named_lines(axes)["model"].get_ydata() - y
    assert np.unique(np.round(np.abs(gaps[np.isfinite(gaps)]), 9)).tolist() == [0.5]
    assert [
        "95 %" in "".join(text.get_text() for text in drawn.axes[0].texts)
        for drawn in (figure, large)
    ] == [True, False]
    assert large.get_size_inches()[0] > figure.get_size_inches()[0]


def test_a_log_is_about_presliding_if_no_motion_ends_far_beyond_the_build_up():
    best = fit(PLAIN, "lugre")
    best.never_slid = False
    longest = float(
        figures.reversals_of(best.traces.time, best.traces.velocity)[0].displacement[-1]
    )
    assert [figures.is_presliding(best, share * longest) for share in (0.3, 0.2)] == [True, False]
    best.never_slid = True
    assert figures.is_presliding(best, 0.0)


def test_names_of_lines_that_end_at_one_place_do_not_overlap():
    figure, ((axes,),) = figures.style.panels(2.0, right=1.0)
    for name in ("a", "b", "c"):
        axes.plot([0.0, 1.0], [0.0, 1.0], label=name)
    figures.style.label_lines(axes)
    assert all(low.y1 <= high.y0 + 1.0 for low, high in pairwise(boxes_of(figure, axes.texts)))


def test_the_window_at_a_reversal_ends_where_samples_are_left_out():
    time = np.concatenate([np.arange(5), 40.0 + np.arange(9), 90.0 + np.arange(3)])
    assert [figures.without_gap(time, window) for window in (slice(2, 17), slice(5, 12))] == [
        slice(5, 14),
        slice(5, 12),
    ]


# --- A fit and a prediction beside their log: signals close up, bands, residuals and their distribution


WORDS = "Shaded: the 95 % band of the measurement."


def test_a_prediction_is_drawn_around_the_largest_difference_in_its_band():
    result = predicted()
    result.effort = F.copy()
    result.effort[400] += 50.0
    near, _ = fit_module.prediction(result).axes
    x = lines(near)["measured"].get_xdata()
    assert x[0] < T[400] < x[-1]
    (band,) = near.collections
    corners, middle = band.get_paths()[0].vertices, lines(near)["model"]
    at = np.interp(corners[:, 0], middle.get_xdata(), middle.get_ydata())
    assert np.abs(corners[:, 1] - at).max() == pytest.approx(0.2, abs=0.02)


def test_a_band_with_a_gap_has_a_single_name():
    axes, x = Figure().add_subplot(), np.array([0.0, 1.0, 2.0, 8.0, 9.0])
    fit_module.draw_band(axes, x, np.zeros(5), np.ones(5))
    assert [band.get_label() for band in axes.collections] == ["95 % band", "_95 % band"]
    assert [band.get_paths()[0].vertices[:, 0].max() for band in axes.collections] == [2.0, 9.0]
    assert {float(end) for end in axes.collections[0].get_paths()[0].vertices[:, 1]} == {-1.0, 1.0}


def with_residual(residual):
    best = fit(PLAIN, "lugre")
    best.traces.residual, best.traces.time = residual, 5e-3 * np.arange(residual.size)
    return fit_module.residuals(best)


def test_the_distribution_of_residuals_is_drawn_with_a_normal_distribution():
    residual = 3.0 + 0.5 * np.random.default_rng(3).normal(size=4000)
    over_time, spread, white = with_residual(residual).axes
    shares, edges, _ = spread.patches[0].get_data()
    assert shares.size == 40
    assert (edges[0], edges[-1]) == pytest.approx(
        (residual.mean() - 4.0 * residual.std(), residual.mean() + 4.0 * residual.std())
    )
    assert shares.sum() == pytest.approx(100.0, abs=0.1)
    normal, at = lines(spread)["normal"].get_data()
    assert normal == pytest.approx(np.interp(at, 0.5 * (edges[1:] + edges[:-1]), shares), abs=1.5)
    assert at[normal.argmax()] == pytest.approx(residual.mean(), abs=0.05)
    assert spread.get_ylim() == over_time.get_ylim()
    assert [
        float(bar.vertices[0, 0]) for bar in white.collections[0].get_paths()[:3]
    ] == pytest.approx([0.0, 5.0, 10.0])


def test_the_band_of_white_noise_contains_95_percent():
    *_, white = with_residual(np.random.default_rng(4).normal(size=2500)).axes
    box = (
        white.patches[0]
        .get_patch_transform()
        .transform_path(white.patches[0].get_path())
        .vertices[:, 1]
    )
    assert (box.min(), box.max()) == pytest.approx((-1.96 / 50.0, 1.96 / 50.0), rel=1e-3)
    assert white.get_ylim() == (-0.3, 1.05)
    assert with_residual(np.tile([1.0, -1.0], 500)).axes[2].get_ylim()[0] == pytest.approx(
        -1.05, abs=0.01
    )


def test_zero_residuals_have_no_normal_distribution():
    _, spread, _ = with_residual(np.zeros(500)).axes
    assert not lines(spread)
    assert spread.patches[0].get_data()[1][[0, -1]].tolist() == [-1.0, 1.0]


def test_no_lag_is_longer_than_the_longest_stretch():
    correlation, count = fit_module.autocorrelation(
        np.arange(5.0), np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    )
    assert (correlation.size, count) == (5, 5)
    assert fit_module.autocorrelation(np.arange(100.0), np.sin(np.arange(100.0)))[0].size == 61
    assert fit_module.autocorrelation(np.arange(3.0), np.full(3, np.nan))[0].size == 1
    assert np.all(fit_module.autocorrelation(np.arange(100.0), np.zeros(100))[0] == 0.0)


def test_a_first_order_process_decays_by_its_pole():
    noise = np.random.default_rng(1).normal(size=40_000)
    signal = lfilter([1.0], [1.0, -0.8], noise)
    correlation, _ = fit_module.autocorrelation(np.arange(signal.size, dtype=float), signal)
    assert correlation[:6] == pytest.approx(0.8 ** np.arange(6), abs=0.03)


def test_no_product_is_taken_across_a_gap():
    signal = np.random.default_rng(2).normal(size=500)
    signal -= signal.mean()
    t = np.arange(500.0)
    alone, _ = fit_module.autocorrelation(t, signal)
    twice, count = fit_module.autocorrelation(
        np.concatenate([t, 1000.0 + t]), np.concatenate([signal, -signal])
    )
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
    assert fit_module.prediction(result).axes[0].get_ylabel() == first
    assert [axes.get_ylabel() for axes in fit_module.prediction_error(result).axes] == errors
    assert [
        report_figure.FIGURES[name].applies(result, "translational")
        for name in ("fit.prediction", "fit.error")
    ] == [True, True]
    result.effort_predicted = result.position_predicted = None
    assert not report_figure.FIGURES["fit.prediction"].applies(result, "translational")


def test_the_error_of_a_position_is_measured_minus_predicted_in_the_band():
    result = predicted()
    result.position_half_width = np.full(T.size, 1e-4)
    *_, off = fit_module.prediction_error(result).axes
    (error,) = off.get_lines()
    assert error.get_ydata().max() == pytest.approx(1e6 * (0.01 * X).max(), rel=1e-3)
    assert np.sign(error.get_ydata()[20]) == np.sign(X[20])
    ends = off.collections[0].get_paths()[0].vertices[:, 1]
    assert (ends.min(), ends.max()) == pytest.approx((-100.0, 100.0))


@pytest.mark.parametrize("band", [None, np.full(T.size, 0.2)])
def test_a_caption_mentions_a_band_only_if_it_is_drawn(band):
    result = predicted()
    result.half_width = band
    assert (report_figure.FIGURES["fit.prediction"].caption(result, "translational") == WORDS) == (
        band is not None
    )
