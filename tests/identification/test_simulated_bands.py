"""Bands around a simulation: deviations of other simulations, measurement noise, and loop error."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from bristle import plants
from bristle.core import Axis, InputError
from bristle.identification import simulated_bands
from bristle.identification.simulated_bands import (
    Bands,
    Widths,
    _rounding,
    half_width,
    simulated_widths,
    with_loops,
    with_parameters,
    within_the_log,
)
from bristle.models.friction import coulomb, coulomb_viscous

PLANT, FRICTION = plants.inertia(M=2.0), coulomb_viscous(F_C=8.0, F_v=30.0)
COUNT = 400
NORMAL = 1.96  # of which 95 % of a normal distribution lie within


def bands_of(scatter=0.0, noise=0.0, unexplained=0.0, count=4, **more):
    draws = more.pop("draws", {"F_C": np.full(count, 8.0)})
    return Bands(draws=draws, scatter=scatter, noise=noise, unexplained=unexplained, **more)


@dataclass
class Stretch:
    """A stretch of a log to and fro, in which a push of 1 moves the position by 1 and asks for 10 more of the effort."""

    loop: str = "closed-loop"
    resolution: float | None = None
    reached: tuple[int, ...] = ()
    count: int = COUNT
    off: float = 0.0
    runs: list = field(default_factory=list)

    def __post_init__(self):
        self.axis, self.samples = Axis(resolution=self.resolution), slice(None)
        self.log = SimpleNamespace(sample_time=0.01)
        self.position = np.full(self.count, self.off)

    def run(self, plant, friction, push):
        reached = self.reached[len(self.runs) % len(self.reached)] if self.reached else self.count
        self.runs.append((plant, friction, push))
        return SimpleNamespace(position=push[:reached], command=10.0 * push[:reached])


@pytest.fixture(autouse=True)
def strokes(monkeypatch):
    """Two strokes of a speed of 1, forward and backward, that rest amid the first one."""
    velocity = np.where(np.arange(COUNT) < 200, 1.0, -1.0)
    position = 0.01 * np.cumsum(velocity)
    segment = SimpleNamespace(
        velocity=velocity,
        position=position,
        signals=lambda dt, transmitted: {"v": velocity, "x": position},
        regressors=(),
    )
    monkeypatch.setattr(
        simulated_bands, "segment_of", lambda log, samples, cutoff, resolution: (segment, 0.0, None)
    )
    return segment


NOTHING = SimpleNamespace(position=np.zeros(COUNT), command=np.zeros(COUNT))


def test_a_band_without_disturbance_has_measurement_noise_and_the_loop_error():
    bands = bands_of(noise=0.3, inflation=1.5, left_in_closed_loop=2e-6, left_in_open_loop=5e-6)
    for loop, left in (("closed-loop", 2e-6), ("open-loop", 5e-6)):
        widths = simulated_widths(bands, PLANT, FRICTION, NOTHING, Stretch(loop, 1e-5))
        assert isinstance(widths, Widths)
        assert widths.effort == pytest.approx(NORMAL * 1.5 * 0.3, rel=1e-5)
        assert widths.position == pytest.approx(np.hypot(0.475e-5, NORMAL * left), rel=1e-5)
    assert _rounding(Stretch(resolution=None)) == 0.0


def test_a_scattering_level_has_one_random_number_for_each_stroke():
    stretch = Stretch()
    widths = simulated_widths(bands_of(scatter=0.1, count=60), PLANT, FRICTION, NOTHING, stretch)
    pushes = np.array([push for *_, push in stretch.runs])
    assert len(pushes) == 40  # of so many sets at most
    assert pushes[:, 20:180] == pytest.approx(np.broadcast_to(pushes[:, 20:21], (40, 160)))
    assert pushes[:, 220:] == pytest.approx(np.broadcast_to(pushes[:, 220:221], (40, 180)))
    assert not np.allclose(np.abs(pushes[:, 100]), np.abs(pushes[:, 300]))
    drawn = np.sort(np.random.default_rng(95).standard_normal((40, 2)), axis=0)
    assert np.sort(pushes[:, 100]) == pytest.approx(0.1 * 38.0 * drawn[:, 0])
    assert widths.position == pytest.approx(NORMAL * np.sqrt(np.mean(pushes**2, axis=0)), rel=1e-5)
    assert widths.effort == pytest.approx(10.0 * widths.position)


def test_the_level_changes_if_a_rest_changes_its_direction(strokes):
    strokes.velocity[180:220] = np.repeat([0.0, -0.0], 20)
    strokes.position[180:220] = strokes.position[180]
    stretch = Stretch()
    simulated_widths(bands_of(scatter=0.1, count=1), PLANT, coulomb(F_C=8.0), NOTHING, stretch)
    levels = 0.8 * np.random.default_rng(95).standard_normal((1, 2))[0]
    assert stretch.runs[0][2] == pytest.approx(np.repeat(levels * [1.0, -1.0], 200))


@pytest.mark.parametrize(("lasting", "block"), [(0.5, 50), (2.0, 200)])
def test_an_unexplained_force_keeps_its_sign_for_its_correlation_time(lasting, block):
    stretch = Stretch()
    simulated_widths(
        bands_of(unexplained=0.7, lasting=lasting, count=1), PLANT, FRICTION, NOTHING, stretch
    )
    push, rng = stretch.runs[0][2], np.random.default_rng(95)
    rng.standard_normal((1, 2))  # the level of each of two strokes is drawn before
    assert push == pytest.approx(
        np.repeat(0.7 * rng.standard_normal((1, COUNT // block))[0], block)
    )


@pytest.mark.parametrize("lasting", [0.0, 0.001])
def test_an_unexplained_force_keeps_its_sign_for_at_least_a_sample(lasting):
    stretch = Stretch()
    simulated_widths(
        bands_of(unexplained=0.7, lasting=lasting, count=1), PLANT, FRICTION, NOTHING, stretch
    )
    assert np.unique(stretch.runs[0][2]).size > 0.8 * COUNT


def test_the_mean_is_that_of_simulations_that_reached_the_sample():
    short = Stretch(reached=(100,))
    widths = simulated_widths(
        bands_of(unexplained=1.0, lasting=100.0, count=3), PLANT, FRICTION, NOTHING, short
    )
    assert np.isfinite(widths.position[:100]).all()
    assert np.isinf(widths.position[100:]).all()
    assert np.isinf(widths.effort[100:]).all()
    assert widths.position[:100] == pytest.approx(
        NORMAL * np.sqrt(np.mean([push[0] ** 2 for *_, push in short.runs])), rel=1e-5
    )


def test_the_shortest_draws_limit_their_number_and_change_only_known_parameters():
    bands = bands_of(draws={"F_C": np.array([7.0, 9.0, 11.0]), "M": np.array([1.0, 3.0])})
    assert (bands.count, bands_of(draws={}).count) == (2, 0)
    assert with_parameters(bands, 1, FRICTION).values == FRICTION.values | {"F_C": 9.0}
    assert with_parameters(bands, 0, PLANT).values == PLANT.values | {"M": 1.0}
    assert with_parameters(bands, 1, FRICTION).kind == FRICTION.kind


def within(monkeypatch, friction=FRICTION, **draws):
    """Draws after they moved towards a fit with a residual of 0.5, whose effort is F_C."""
    monkeypatch.setattr(
        simulated_bands,
        "_efforts",
        lambda bands, *models: [np.full(9, level) for level in bands.draws["F_C"]],
    )
    bands = bands_of(draws={name: np.array(values) for name, values in draws.items()})
    traces = SimpleNamespace(residual=np.tile([0.5, -0.5], 4))
    fit = SimpleNamespaceFit(
        SimpleNamespaceFit(None, bands=bands), plant=PLANT, friction=friction, traces=traces
    )
    return {
        name: values.tolist()
        for name, values in within_the_log(fit, None).resampling.bands.draws.items()
    }


@pytest.mark.parametrize(
    ("levels", "masses", "moved"),
    [
        # The middle describes the log: draws move towards 8.2 and 2.2.
        ([8.2, 9.0, 4.0], [2.2, 2.2, 1.0], ([8.2, 8.7, 7.7], [2.2, 2.2, 2.2 - 1.2 / 8.4])),
        ([8.9, 9.0, 9.1], [2.2, 2.1, 2.0], ([8.9, 9.0, 9.1], [2.2, 2.1, 2.0])),
        # It does not: they move towards the fit, at 8 and 2.
        ([10.0, 9.5, 4.0], [2.2, 2.3, 1.0], ([8.5, 8.5, 7.5], [2.05, 2.1, 1.875])),
    ],
)
def test_a_draw_that_contradicts_the_log_moves_towards_the_centre(
    monkeypatch, levels, masses, moved
):
    drawn = within(monkeypatch, F_C=levels, M=masses)
    assert [drawn["F_C"], drawn["M"]] == [pytest.approx(values) for values in moved]


def test_a_draw_that_diverges_and_other_numbers_stay(monkeypatch):
    endless = SimpleNamespace(values=FRICTION.values | {"F_v": np.inf})
    moved = within(
        monkeypatch,
        endless,
        F_C=[np.nan, 9.0],
        M=[2.2, 2.2],
        F_v=[np.inf, np.inf],
        lag=[1e-3, 2e-3],
    )
    assert moved["M"] == pytest.approx([2.2, 2.1])
    assert (moved["F_v"], moved["lag"]) == ([np.inf, np.inf], [1e-3, 2e-3])


def looped(stretch, bands, monkeypatch, *, simulated=("closed-loop",), lag=None, segments=()):
    fit = SimpleNamespaceFit(
        SimpleNamespaceFit(None, bands=bands), plant=PLANT, friction=FRICTION, lag=lag
    )
    axes = []

    def of(log, axis, loop, part):
        axes.append((axis, loop, part))
        return stretch

    monkeypatch.setattr(
        simulated_bands, "can_be_simulated", lambda log, axis, loop: loop in simulated
    )
    monkeypatch.setattr(simulated_bands.Stretch, "of", of)
    log = SimpleNamespace(kind="translational", segments=segments)
    return with_loops(fit, [(log, None)]).resampling.bands, axes


@dataclass
class SimpleNamespaceFit:
    """What of a fit or its resampling is asked for."""

    resampling: object
    bands: object = None
    plant: object = None
    friction: object = None
    lag: float | None = None
    traces: object = None


def test_the_loop_error_completes_a_band_of_95_percent_of_the_positions(monkeypatch):
    bands, axes = looped(
        Stretch(off=1e-3, resolution=1e-3), bands_of(left_in_open_loop=7.0), monkeypatch
    )
    assert bands.left_in_closed_loop == pytest.approx(
        1e-3 * np.sqrt(1.0 - 0.475**2) / NORMAL, rel=1e-5
    )
    assert bands.left_in_open_loop == 7.0  # not simulated
    assert [(loop, part) for _, loop, part in axes] == [("closed-loop", slice(None))]
    within, _ = looped(
        Stretch(off=1e-3, resolution=3e-3), bands_of(left_in_closed_loop=7.0), monkeypatch
    )
    assert within.left_in_closed_loop == 0.0
    few, _ = looped(Stretch(off=1.0, count=5), bands_of(left_in_closed_loop=7.0), monkeypatch)
    assert few.left_in_closed_loop == 7.0


def test_a_loop_has_the_identified_lag_and_each_segment_is_simulated(monkeypatch):
    parts = (slice(0, 10), slice(10, 20))
    for lag in (None, 2e-3):
        _, axes = looped(
            Stretch(),
            bands_of(),
            monkeypatch,
            lag=lag,
            segments=parts,
            simulated=("closed-loop", "open-loop"),
        )
        assert [axis.lag for axis, *_ in axes] == [lag or 0.0] * 4 if lag else len(axes) == 4
        assert [(loop, part) for _, loop, part in axes] == [
            (loop, part) for loop in ("closed-loop", "open-loop") for part in parts
        ]


@pytest.mark.parametrize(("count", "members"), [(COUNT, 12), (80_000, 5), (400_000, 3)])
def test_more_samples_need_fewer_simulations_for_the_loop_error(monkeypatch, count, members):
    stretch = Stretch(count=count)
    looped(stretch, bands_of(count=20), monkeypatch)
    assert len(stretch.runs) == 1 + members


def test_a_fit_without_resampling_has_no_bands():
    fit = SimpleNamespaceFit(None)
    assert with_loops(fit, []) is fit


@pytest.mark.parametrize(("bandwidth", "share"), [(10.0, 0.2), (50.0, 1.0), (80.0, 1.0)])
def test_noise_counts_by_the_bandwidth_of_rows_and_adds_in_squares(monkeypatch, bandwidth, share):
    monkeypatch.setattr(simulated_bands, "half_cycle_starts", lambda dataset: ())
    dataset = SimpleNamespace(
        segments=(),
        time=np.zeros(3),
        bandwidth=bandwidth,
        sample_time=0.01,
        rows_of=lambda efforts: np.zeros(3),
    )
    for count in (0, 1, 5):
        width = half_width(
            bands_of(noise=0.4, unexplained=0.3, inflation=2.0, count=count),
            PLANT,
            FRICTION,
            dataset,
        )
        assert width == pytest.approx(NORMAL * 2.0 * np.sqrt(share * 0.16 + 0.09), rel=1e-5)
    for drawn in ([1.0, 4.0], [1.0, np.inf, 4.0]):  # a draw that diverges is left out
        efforts = iter(drawn)
        dataset.rows_of = lambda _, efforts=efforts: np.full(3, next(efforts))
        assert half_width(bands_of(count=len(drawn)), PLANT, FRICTION, dataset) == pytest.approx(
            NORMAL * np.sqrt(4.5), rel=1e-5
        )
    most = iter([1.0, np.nan, np.inf])
    dataset.rows_of = lambda _: np.full(3, next(most))
    with pytest.raises(InputError, match="diverges with 2 of 3 draws"):
        half_width(bands_of(count=3), PLANT, FRICTION, dataset)
