"""What a study keeps of each run, how draws become runs, and how many runs make a block."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core import InputError, Status
from bristle.simulation.statistics import Statistics, statistics_of
from bristle.study import plan
from bristle.study.plan import METRICS, Block, Metric, Sampling, Study, block_for, metrics_from, steps_of, usual_metrics
from bristle.study.values import Drawn, Joint, Target


def metric(name, column=None):
    return Metric(column or name, "plain", name, "m")


def test_a_metric_is_reported_in_words_with_the_variant_where_there_are_several():
    assert metric("following_error.peak_to_peak").described == "following error, peak to peak"
    assert metric("by_direction.forward.rms", "plain.by_direction.forward.rms").described == "plain: following error forward, rms"
    assert metric("effort.rms").described == "effort, rms"


def test_a_metric_is_read_from_the_place_in_a_result():
    numbers = [Statistics(*(float(10 * group + k) for k in range(6))) for group in range(5)]
    forward, backward = numbers[2:4]
    result = Some(following_error=numbers[0], true_error=numbers[1], motion=numbers[4], effort_rms=7.0, effort_peak=9.0, status=Status.OK)
    result.by_direction = {"forward": forward, "backward": backward}
    assert metric("effort.rms").of(result) == 7.0
    assert metric("effort.peak").of(result) == 9.0
    for name in plan.STATISTICS:
        assert metric(f"true_error.{name}").of(result) == getattr(numbers[1], name)
        assert metric(f"by_direction.backward.{name}").of(result) == getattr(backward, name)
        assert metric(f"motion.{name}").of(result) == getattr(numbers[4], name)
    result.status = Status.NOT_FINITE
    assert all(np.isnan(metric(name).of(result)) for name in METRICS)


def test_a_metric_of_many_runs_is_that_of_each():
    position, effort = np.random.default_rng(1).normal(size=(2, 3, 50))
    for name in plan.STATISTICS:
        expected = [getattr(statistics_of(row), name) for row in position]
        assert metric(f"motion.{name}").along(position, effort) == pytest.approx(expected)
    assert metric("effort.rms").along(position, effort) == pytest.approx(np.linalg.norm(effort, axis=1) / np.sqrt(50.0))
    assert metric("effort.peak").along(position, effort) == pytest.approx([max(abs(row.min()), row.max()) for row in effort])
    assert np.all(np.isnan(metric("following_error.rms").along(position, effort)))
    assert metric("effort.peak").along(position[:, :0], effort[:, :0]).tolist() == [0.0, 0.0, 0.0]


def experiment(*names, effort=None, **run):
    known = {"duration": 2.0, "sample_time": 1e-3, "substeps": 5}
    return Some(kind="rotational", variants=[Some(name=name, effort=effort, run=Some(**known | run)) for name in names])


def test_usual_metrics_are_those_of_the_motion_where_no_loop_is_closed():
    assert usual_metrics(experiment("a")) == ("following_error.peak_to_peak", "effort.rms")
    assert usual_metrics(experiment("a", effort=1)) == ("motion.peak_to_peak", "effort.rms")
    mixed = experiment("a", "b")
    mixed.variants[0].effort = 1
    assert usual_metrics(mixed)[0] == "following_error.peak_to_peak"


def test_metrics_cover_every_variant_unless_they_name_a_variant():
    (first, second), (alone,) = (
        metrics_from(["motion.rms"], experiment("a", "b"), ""),
        metrics_from(["b.effort.rms"], experiment("a", "b"), ""),
    )
    assert [(item.column, item.variant, item.name, item.unit) for item in (first, second, alone)] == [
        ("a.motion.rms", "a", "motion.rms", "rad"),
        ("b.motion.rms", "b", "motion.rms", "rad"),
        ("b.effort.rms", "b", "effort.rms", "N*m"),
    ]
    assert metrics_from(["motion.rms"], experiment("a"), "")[0].column == "motion.rms"


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["motion.rms", 3], r"keep\.metrics\[1\]: must be the name"),
        (["motion.rmx"], r"keep\.metrics\[0\]: is not a metric.*Did you mean 'motion\.rms'"),
        (["motion.rms", "a.motion.rms"], r"keep\.metrics: is named twice.*a\.motion\.rms"),
    ],
)
def test_an_unknown_metric_is_refused_with_the_place(names, message):
    with pytest.raises(InputError, match=message):
        metrics_from(names, experiment("a", "b"), "keep.metrics")


def test_draws_for_indices_are_two_more_than_there_are_causes():
    plain, indices = (Sampling("random", 3, ("a", "b", "c"), 64, chosen) for chosen in (False, True))
    assert (plain.per_row, plain.count, indices.per_row, indices.count) == (1, 64, 5, 320)


def test_the_checksum_is_that_of_the_drawn_points():
    assert Sampling("random", 3, ("a",), 8).checksum() == ""
    first, again, other = (Sampling("sobol", seed, ("a",), 8).checksum() for seed in (3, 3, 4))
    assert first == again != other
    assert len(first) == 64
    assert Sampling("sobol", 3, (), 8).numbers(0, 8).shape == (8, 0)


def test_no_draw_lies_at_an_end():
    assert plan.SMALLEST == 2.0**-54
    for method in plan.SAMPLINGS:
        drawn = Sampling(method, 3, ("a",), 4096).numbers(0, 4096)
        assert 0.0 < drawn.min() < 1e-2
        assert 1.0 - 1e-2 < drawn.max() < 1.0


def test_latin_draws_fill_each_stripe_once():
    drawn = np.sort(Sampling("latin_hypercube", 3, ("a", "b"), 50).numbers(0, 50), axis=0)
    assert np.all(np.floor(50.0 * drawn) == np.arange(50)[:, np.newaxis])


def targeted(path, unit="N"):
    return Target(path, Some(choices=(), quantity="force", unit=lambda kind: unit), "translational")


def study(rows=3, block=4, grid=((1.0, 2.0), (5.0, 6.0, 7.0))):
    causes = (
        Drawn(targeted("friction.F_C"), "uniform", (1.0, 2.0)),
        Joint("fit", {"friction.K": np.arange(8.0).reshape(4, 2)}, {"friction.K": "N/m"}),
    )
    points = tuple((targeted(f"plant.{name}", "kg"), values) for name, values in zip("ab", grid, strict=False))
    sampling = Sampling("random", 7, ("friction.F_C", "fit"), rows)
    return Study("s", experiment("a"), {}, None, 7, sampling, causes, points, (metric("motion.rms"),), block, {}, {})


def test_each_draw_is_made_at_every_point_of_the_grid():
    item = study()
    assert (item.count, len(item.points)) == (18, 6)
    assert item.points[1] == {"plant.a": 1.0, "plant.b": 6.0}
    values = item.values(Block(4, 9))
    assert values["plant.a"].tolist() == [2.0, 2.0, 1.0, 1.0, 1.0]
    assert values["plant.b"].tolist() == [6.0, 7.0, 5.0, 6.0, 7.0]
    drawn = item.sampling.numbers(0, 3)
    assert values["friction.F_C"] == pytest.approx(1.0 + drawn[[0, 0, 1, 1, 1], 0])
    assert values["friction.K"].shape == (5, 2)
    assert study(grid=()).values(Block(1, 2)).keys() == {"friction.F_C", "friction.K"}


def test_blocks_hold_every_run_once():
    blocks = study().blocks
    assert [(block.first, block.last, block.count) for block in blocks] == [(0, 4, 4), (4, 8, 4), (8, 12, 4), (12, 16, 4), (16, 18, 2)]
    assert blocks[1].file == "0000000004.parquet"
    assert study().seeds(blocks[1]) == [plan.seed_of_run(7, number) for number in (4, 5, 6, 7)]


def test_columns_have_their_role_and_unit():
    columns = study().columns
    assert list(columns) == [
        *("run", "seed", "status", "reason", "friction.F_C", "friction.K[0]", "friction.K[1]", "plant.a", "plant.b", "motion.rms")
    ]
    assert [columns[name]["role"] for name in ("run", "friction.K[1]", "plant.b", "motion.rms")] == ["run", "drawn", "grid", "metric"]
    assert [columns[name]["unit"] for name in ("run", "friction.K[1]", "plant.b", "motion.rms")] == ["", "N/m", "kg", "m"]
    assert columns["motion.rms"]["description"] == "position, rms"
    assert study(rows=1, block=99).columns == columns


def test_steps_are_those_of_all_variants():
    assert steps_of(experiment("a", "b")) == 2 * 2000 * 5
    assert steps_of(experiment("a", substeps=0)) == 2000


@pytest.mark.parametrize(
    ("runs", "steps", "block"), [(10_000_000, 1, 4096), (10_000_000, 10_000, 1000), (320, 1, 10), (321, 1, 11), (10, 10**9, 1), (10, 0, 1)]
)
def test_a_block_takes_a_second_or_two_and_is_a_small_part_of_a_study(runs, steps, block, monkeypatch):
    monkeypatch.setattr(plan, "steps_of", lambda experiment: steps)
    assert block_for(runs, None) == block
