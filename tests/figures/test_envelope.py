"""A long signal is drawn short, and nothing that a line of this width can show is lost."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bristle.figures.style import envelope, line, runs, spread

SIGNALS = arrays(float, st.integers(1, 600), elements=st.floats(-1e3, 1e3))


@given(y=SIGNALS, columns=st.integers(1, 40))
def test_extremes_and_ends_are_kept_exactly(y, columns):
    kept = envelope(y, columns)
    assert kept.size <= max(4 * columns, 1)
    assert np.all(np.diff(kept) > 0)
    assert (kept[0], kept[-1]) == (0, y.size - 1)
    assert (y[kept].min(), y[kept].max()) == (y.min(), y.max())


@given(y=SIGNALS, columns=st.integers(1, 40))
def test_each_sample_lies_between_kept_samples_nearby(y, columns):
    kept = envelope(y, columns)
    reach = -(-y.size // columns)
    for k in range(y.size):
        near = y[kept[np.abs(kept - k) <= reach]]
        assert near.min() <= y[k] <= near.max()


@given(lengths=st.lists(st.integers(2, 50), min_size=1, max_size=5))
def test_a_line_breaks_only_at_gaps(lengths):
    starts = np.cumsum([0, *(1.0 + 0.01 * n for n in lengths[:-1])])
    t = np.concatenate([start + 0.01 * np.arange(n) for start, n in zip(starts, lengths, strict=True)])
    x, y = line(t, np.cos(t))
    assert np.isnan(y).sum() == len(lengths) - 1
    assert set(x[np.isfinite(x)]) <= set(t)
    assert [part.stop - part.start for part in runs(t, t)] == lengths


def test_short_stretches_do_not_make_a_long_stretch_coarse():
    lengths = [9000, *[5] * 60]
    starts = np.cumsum([0.0, *(2.0 + n for n in lengths[:-1])])
    t = np.concatenate([start + np.arange(n) for start, n in zip(starts, lengths, strict=True)])
    y = np.sin(0.05 * t)
    x, kept = line(t, y)
    long = np.isfinite(x) & (x < lengths[0])
    # Straight lines between what is drawn stay close to the signal.
    assert np.max(np.abs(np.interp(t[: lengths[0]], x[long], kept[long]) - y[: lengths[0]])) < 0.35
    assert x.size < 4 * 480 + 12 * len(lengths)


@settings(max_examples=50)
@given(points=arrays(float, st.tuples(st.just(2), st.integers(1, 400)), elements=st.floats(-10, 10)))
def test_every_point_of_a_cloud_is_near_a_drawn_point(points):
    x, y = points
    cells = (12, 8)
    kept = spread(x, y, cells)
    assert kept.size <= 12 * 8 + 4
    cell = np.array([np.ptp(x) / cells[0], np.ptp(y) / cells[1]])
    apart = np.abs(points[:, :, None] - points[:, None, kept]) <= cell[:, None, None] + 1e-9
    assert apart.all(axis=0).any(axis=1).all()
    for ends in (x, y):
        assert (ends[kept].min(), ends[kept].max()) == (ends.min(), ends.max())
