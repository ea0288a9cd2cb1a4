"""What a study file may say and how it is refused, what a study keeps of each run, how draws become runs."""

import dataclasses
import re
from types import SimpleNamespace as Some

import numpy as np
import pytest
from scipy import stats
from tests.apps.study.conftest import STUDY

import bristle as br
from bristle.apps.study import plan, read_study_file
from bristle.apps.study.plan import (
    METRICS,
    SAMPLINGS,
    Block,
    Metric,
    Sampling,
    Study,
    block_for,
    metrics_from,
    seed_of_run,
    steps_of,
    usual_metrics,
)
from bristle.apps.study.values import (
    Drawn,
    Joint,
    Target,
    columns_of,
    drawn_from,
    fitted_at,
    target_at,
)
from bristle.files.arrays import write_arrays


def metric(name, column=None):
    return Metric(column or name, "plain", name, "m")


def test_a_metric_is_reported_in_words_with_the_variant_where_there_are_several():
    assert metric("following_error.peak_to_peak").described == "following error, peak to peak"
    assert (
        metric("by_direction.forward.rms", "plain.by_direction.forward.rms").described
        == "plain: following error forward, rms"
    )
    assert metric("effort.rms").described == "effort, rms"


def test_a_metric_is_read_from_the_place_in_a_result():
    numbers = [
        br.simulation.Statistics(*(float(10 * group + k) for k in range(6))) for group in range(5)
    ]
    forward, backward = numbers[2:4]
    result = Some(
        following_error=numbers[0],
        true_error=numbers[1],
        motion=numbers[4],
        effort_rms=7.0,
        effort_peak=9.0,
        status=br.core.Status.OK,
    )
    result.by_direction = {"forward": forward, "backward": backward}
    assert metric("effort.rms").of(result) == 7.0
    assert metric("effort.peak").of(result) == 9.0
    for name in plan.STATISTICS:
        assert metric(f"true_error.{name}").of(result) == getattr(numbers[1], name)
        assert metric(f"by_direction.backward.{name}").of(result) == getattr(backward, name)
        assert metric(f"motion.{name}").of(result) == getattr(numbers[4], name)
    result.status = br.core.Status.NOT_FINITE
    assert all(np.isnan(metric(name).of(result)) for name in METRICS)


def test_a_metric_of_many_runs_is_that_of_each():
    position, effort = np.random.default_rng(1).normal(size=(2, 3, 50))
    for name in plan.STATISTICS:
        expected = [getattr(br.simulation.statistics_of(row), name) for row in position]
        assert metric(f"motion.{name}").along(position, effort) == pytest.approx(expected)
    assert metric("effort.rms").along(position, effort) == pytest.approx(
        np.linalg.norm(effort, axis=1) / np.sqrt(50.0)
    )
    assert metric("effort.peak").along(position, effort) == pytest.approx(
        [max(abs(row.min()), row.max()) for row in effort]
    )
    assert np.all(np.isnan(metric("following_error.rms").along(position, effort)))
    assert metric("effort.peak").along(position[:, :0], effort[:, :0]).tolist() == [0.0, 0.0, 0.0]


def experiment(*names, effort=None, **run):
    known = {"duration": 2.0, "sample_time": 1e-3, "substeps": 5}
    return Some(
        kind="rotational",
        variants=[Some(name=name, effort=effort, run=Some(**known | run)) for name in names],
    )


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
    assert [
        (item.column, item.variant, item.name, item.unit) for item in (first, second, alone)
    ] == [
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
    with pytest.raises(br.core.InputError, match=message):
        metrics_from(names, experiment("a", "b"), "keep.metrics")


def test_draws_for_indices_are_two_more_than_there_are_causes():
    plain, indices = (
        Sampling("random", 3, ("a", "b", "c"), 64, chosen) for chosen in (False, True)
    )
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
    points = tuple(
        (targeted(f"plant.{name}", "kg"), values) for name, values in zip("ab", grid, strict=False)
    )
    sampling = Sampling("random", 7, ("friction.F_C", "fit"), rows)
    return Study(
        "s",
        experiment("a"),
        {},
        None,
        7,
        sampling,
        causes,
        points,
        (metric("motion.rms"),),
        block,
        {},
        {},
    )


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
    assert [(block.first, block.last, block.count) for block in blocks] == [
        (0, 4, 4),
        (4, 8, 4),
        (8, 12, 4),
        (12, 16, 4),
        (16, 18, 2),
    ]
    assert blocks[1].file == "0000000004.parquet"
    assert study().seeds(blocks[1]) == [plan.seed_of_run(7, number) for number in (4, 5, 6, 7)]


def test_columns_have_their_role_and_unit():
    columns = study().columns
    assert list(columns) == [
        *(
            "run",
            "seed",
            "status",
            "reason",
            "friction.F_C",
            "friction.K[0]",
            "friction.K[1]",
            "plant.a",
            "plant.b",
            "motion.rms",
        )
    ]
    assert [
        columns[name]["role"] for name in ("run", "friction.K[1]", "plant.b", "motion.rms")
    ] == ["run", "drawn", "grid", "metric"]
    assert [
        columns[name]["unit"] for name in ("run", "friction.K[1]", "plant.b", "motion.rms")
    ] == ["", "N/m", "kg", "m"]
    assert columns["motion.rms"]["description"] == "position, rms"
    assert study(rows=1, block=99).columns == columns


def test_steps_are_those_of_all_variants():
    assert steps_of(experiment("a", "b")) == 2 * 2000 * 5
    assert steps_of(experiment("a", substeps=0)) == 2000


@pytest.mark.parametrize(
    ("runs", "steps", "block"),
    [
        (10_000_000, 1, 4096),
        (10_000_000, 10_000, 1000),
        (320, 1, 10),
        (321, 1, 11),
        (10, 10**9, 1),
        (10, 0, 1),
    ],
)
def test_a_block_takes_a_second_or_two_and_is_a_small_part_of_a_study(
    runs, steps, block, monkeypatch
):
    monkeypatch.setattr(plan, "steps_of", lambda experiment: steps)
    assert block_for(runs, None) == block


# --- the values of a run follow from the seed of the study and the number of the run ---------------------------------


@pytest.mark.parametrize("method", SAMPLINGS)
@pytest.mark.parametrize("indices", [False, True])
def test_a_draw_is_the_same_whichever_block_it_is_in(method, indices):
    sampling = Sampling(method, 3, ("a", "b", "c"), 64, indices)
    together = sampling.numbers(0, sampling.count)
    for first, last in ((0, 1), (1, 7), (5, 6), (13, 40), (sampling.count - 3, sampling.count)):
        assert np.array_equal(sampling.numbers(first, last), together[first:last])
    assert np.all((together > 0.0) & (together < 1.0))
    if not indices:
        assert stats.kstest(together[:, 0], "uniform").pvalue > 1e-3


def test_an_additional_cause_leaves_other_random_draws_unchanged():
    alone, beside = (Sampling("random", 3, names, 50) for names in (("a",), ("b", "a")))
    assert np.array_equal(alone.numbers(0, 50)[:, 0], beside.numbers(0, 50)[:, 1])
    assert abs(np.corrcoef(beside.numbers(0, 50).T)[0, 1]) < 0.4


def test_the_draws_for_sobol_indices_exchange_one_coordinate_after_the_other():
    rows = Sampling("sobol", 3, ("a", "b"), 8, indices=True).numbers(0, 32).reshape(8, 4, 2)
    custom, second, first_exchanged, second_exchanged = rows.transpose(1, 0, 2)
    assert np.array_equal(first_exchanged[:, 0], second[:, 0])
    assert np.array_equal(first_exchanged[:, 1], custom[:, 1])
    assert np.array_equal(second_exchanged[:, 0], custom[:, 0])
    assert np.array_equal(second_exchanged[:, 1], second[:, 1])
    assert not np.any(custom == second)


def test_seeds_of_runs_differ():
    seeds = {seed_of_run(1, number) for number in range(10_000)}
    assert len(seeds) > 9_990
    assert min(seeds) >= 0
    assert max(seeds) < 2**31


def fit_in(folder):
    """Write what an identification leaves of a model: its file and correlated draws."""
    folder.mkdir()
    (folder / "model.toml").write_text(
        'schema = 1\nkind = "translational"\n[plant]\nmodel = "inertia"\nM = 1.0\n[friction]\nmodel = "lugre"\n'
        "F_C = 1.0\n"
        "F_S = 1.5\nv_S = 1e-3\nsigma_0 = 1e5\nsigma_1 = 316.0\nsigma_2 = 0.4\n"
    )
    chol = np.linalg.cholesky([[1.0, 0.8, -0.6], [0.8, 1.0, -0.3], [-0.6, -0.3, 1.0]])
    drawn = np.random.default_rng(1).standard_normal((500, 3)) @ chol.T
    draws = {
        "F_C": 1.0 + 0.05 * drawn[:, 0],
        "sigma_2": 0.4 + 0.02 * drawn[:, 1],
        "M": 1.0 + 0.01 * drawn[:, 2],
    }

    class Folder:
        def write(self, name, data):
            (folder / name).write_bytes(data)

    write_arrays(Folder(), "draws", draws)
    assert br.read_model(folder / "model.toml").friction.name == "lugre"
    return draws


def test_joint_draws_keep_the_correlations_of_the_fit(bench):
    draws = fit_in(bench.folder / "results")
    study = bench.study(
        STUDY.replace(
            '"friction.F_C" = { normal = ["1 N", "0.1 N"] }',
            '"friction" = { from = "results", draws = "bootstrap" }',
        )
        .replace(
            '"plant.M" = { uniform = ["0.8 kg", "1.2 kg"] }',
            '"plant" = { from = "results", draws = "bootstrap" }',
        )
        .replace("runs = 12", "runs = 20000")
    )
    assert [cause.name for cause in study.causes] == ["results"]
    assert study.units == {"friction.F_C": "N", "friction.sigma_2": "N*s/m", "plant.M": "kg"}
    values = study.values(Block(0, 20000))
    drawn = np.corrcoef([values[name] for name in ("friction.F_C", "friction.sigma_2", "plant.M")])
    fitted = np.corrcoef([draws[name] for name in ("F_C", "sigma_2", "M")])
    assert np.max(np.abs(drawn - fitted)) < 0.02
    rows = set(zip(*(draws[name] for name in ("F_C", "sigma_2", "M")), strict=True))
    assert set(zip(*values.values(), strict=True)) <= rows


def test_draws_of_another_model_are_refused(bench):
    fit_in(bench.folder / "results")
    (bench.folder / "rig.toml").write_text(
        (bench.folder / "rig.toml")
        .read_text()
        .replace('"lugre"', '"coulomb_viscous"')
        .split("F_S")[0]
        + 'F_v = "1 N*s/m"\n[effort]\nmodel = "constant"\nlevel = 2.0\n'
        + '[run]\nduration = "0.1 s"\nsample_time = "1 ms"\n'
    )
    with pytest.raises(
        ValueError,
        match=r"the identification has lugre .translational., but the experiment has coulomb_v",
    ):
        bench.study(
            STUDY.replace(
                '"friction.F_C" = { normal = ["1 N", "0.1 N"] }',
                '"friction" = { from = "results", draws = "bootstrap" }',
            )
        )


def target(**changes):
    return Target(
        "friction.F_C", br.core.Variable("force", "level", min=0.0), "translational", **changes
    )


@pytest.mark.parametrize(
    ("distribution", "numbers", "values"),
    [
        ("choice", (1.0, 2.0, 4.0), [1.0, 1.0, 2.0, 4.0, 4.0]),
        (
            "normal",
            (10.0, 2.0),
            [
                10.0 - 2.0 * 3.090232,
                10.0 - 2.0 * 0.524401,
                10.0,
                10.0 + 2.0 * 0.524401,
                10.0 + 2.0 * 3.090232,
            ],
        ),
        ("uniform", (10.0, 20.0), [10.01, 13.0, 15.0, 17.0, 19.99]),
        ("log_uniform", (1.0, 100.0), [10.0**0.002, 10.0**0.6, 10.0, 10.0**1.4, 10.0**1.998]),
    ],
)
def test_a_distribution_is_the_inverse_of_the_function(distribution, numbers, values):
    shares = np.array([0.001, 0.3, 0.5, 0.7, 0.999])
    cause = Drawn(target(), distribution, numbers)
    assert cause.values(shares)["friction.F_C"] == pytest.approx(np.array(values), rel=1e-6)
    assert (cause.name, cause.units) == ("friction.F_C", {"friction.F_C": "N"})


def test_rows_of_a_fit_are_drawn_whole_and_equally_often():
    joint = Joint(
        "fit", {"a": np.array([1.0, 2.0, 3.0]), "b": np.array([[1, 1], [2, 2], [3, 3]])}, {}
    )
    values = joint.values(np.array([0.0, 0.32, 0.34, 0.66, 0.68, 1.0]))
    assert values["a"].tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert values["b"][:, 0].tolist() == [1, 1, 2, 2, 3, 3]
    assert Drawn(target(), "choice", ("x", "y")).values(np.array([0.2, 1.0]))[
        "friction.F_C"
    ].tolist() == ["x", "y"]


def test_a_value_is_read_in_si_within_the_range():
    assert target().number("2 kN", "") == 2000.0
    assert target(is_whole=True).number(3.0, "") == 3.0
    with pytest.raises(br.core.InputError, match="must be a whole number"):
        target(is_whole=True).number(2.5, "")
    with pytest.raises(br.core.InputError, match=r"a\[1\]"):
        target().numbers(["1 N", "-1 N"], "a")
    named = Target(
        "reference.model",
        br.core.Variable("1", "shape", choices=("round", "square")),
        "translational",
    )
    assert (named.unit, named.number("square", "")) == ("", "square")
    assert target().unit == "N"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "has no distribution"),
        ({"normal": [1.0, 2.0], "uniform": [1.0, 2.0]}, "has two distributions"),
        ({"normale": [1.0, 2.0]}, "is not a distribution.*Did you mean 'normal'"),
        ({"uniform": [1.0]}, "allowed two values"),
        ({"uniform": [1.0, 2.0, 3.0]}, "allowed two values"),
        ({"choice": []}, "allowed at least one value"),
        ({"choice": 3.0}, "allowed at least one value"),
        ({"normal": [1.0, 0.0]}, r"normal\[1\]: must be positive"),
        ({"uniform": [2.0, 2.0]}, r"uniform\[1\]: must be above the lowest value.*allowed > 2"),
        (
            {"log_uniform": [0.0, 2.0]},
            r"log_uniform\[0\]: must be positive, because log_uniform takes its logarithm",
        ),
    ],
)
def test_a_distribution_that_does_not_fit_is_reported(table, words):
    with pytest.raises(br.core.InputError, match=words):
        drawn_from(table, target(), "vary")


def test_distributions_that_fit_are_read():
    assert drawn_from({"choice": [1.0]}, target(), "").numbers == (1.0,)
    assert drawn_from({"normal": ["1 kN", "1 N"]}, target(), "").numbers == (1000.0, 1.0)
    assert drawn_from({"log_uniform": [1.0, 2.0]}, target(), "").distribution == "log_uniform"
    assert drawn_from({"choice": [1.0, 2.0, 3.0]}, target(is_whole=True), "").numbers == (
        1.0,
        2.0,
        3.0,
    )
    with pytest.raises(br.core.InputError, match="a continuous quantity"):
        drawn_from({"uniform": [1.0, 2.0]}, target(is_whole=True), "")


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("friction.seed", r"is a seed, which \[vary\] cannot contain"),
        ("run.seeds", r"is a seed, which \[vary\] cannot contain"),
        ("compare.none.friction.F_C", r"is not a variant.*compare\.plain\.…, compare\.stiff\.…"),
        ("compare.plain.friction", "is not a variant"),
        (
            "sensor.noises",
            r"is not a value of this experiment.*allowed sensor\..*Did you mean 'noise'",
        ),
    ],
)
def test_a_key_that_is_not_varied_is_reported(bench, key, words):
    experiment, (data, *_) = (
        br.read_experiment(bench.folder / "loop.toml"),
        br.files.read_toml(bench.folder / "loop.toml"),
    )
    with pytest.raises(br.core.InputError, match=words) as error:
        target_at(key, experiment, data, "vary")
    assert "seed" not in str(error.value).partition("allowed")[2]


def test_a_key_is_a_value_with_the_unit_and_whether_steps_are_whole(bench):
    experiment, (data, *_) = (
        br.read_experiment(bench.folder / "loop.toml"),
        br.files.read_toml(bench.folder / "loop.toml"),
    )
    result = {
        key: target_at(key, experiment, data, "")
        for key in ("run.delay", "compare.stiff.controller.k_v", "sensor.noise")
    }
    assert [(item.unit, item.is_whole) for item in result.values()] == [
        ("", True),
        ("N*s/m", False),
        ("m", False),
    ]
    assert result["sensor.noise"].path == "sensor.noise"


FROM = {"from": "results", "draws": "bootstrap"}


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"from": "results"}, "needs the key draws"),
        ({"draws": "bootstrap"}, "needs the key from"),
        (FROM | {"draws": "jackknife"}, "are not draws of an identification.*allowed bootstrap"),
        (FROM | {"from": 3}, "must be the name of a folder"),
        (FROM | {"from": ""}, "must be the name of a folder"),
        (FROM | {"rows": 3}, "rows: unknown key"),
    ],
)
def test_draws_of_a_fit_that_are_named_wrongly_are_reported(tmp_path, table, words):
    with pytest.raises(br.core.InputError, match=words):
        fitted_at(table, tmp_path, "vary.friction")


def test_a_fit_without_draws_is_reported(bench):
    fit_in(bench.folder / "results")
    (file,) = (bench.folder / "results").glob("draws.*")
    fitted = fitted_at(FROM, bench.folder, "vary")
    assert (fitted.folder, fitted.friction.name, fitted.origin.name) == (
        "results",
        "lugre",
        file.name,
    )
    file.unlink()
    with pytest.raises(br.core.InputError, match=r"names results without draws.*--draws 1000"):
        fitted_at(FROM, bench.folder, "vary")


def test_draws_go_to_the_section_whose_parameters_they_are(bench):
    draws = fit_in(bench.folder / "results")
    fitted, experiment = (
        fitted_at(FROM, bench.folder, "vary"),
        br.read_experiment(bench.folder / "rig.toml"),
    )
    columns, units = columns_of(fitted, "friction", experiment, "vary")
    assert units == {"friction.F_C": "N", "friction.sigma_2": "N*s/m"}
    assert columns["friction.F_C"].tolist() == draws["F_C"].tolist()
    shorter = dataclasses.replace(fitted, draws=fitted.draws | {"M": fitted.draws["M"][:7]})
    assert columns_of(shorter, "friction", experiment, "vary")[0]["friction.F_C"].size == 7
    with pytest.raises(
        br.core.InputError, match=r"cannot use draws of an identification.*plant or friction"
    ):
        columns_of(fitted, "sensor", experiment, "vary")
    with pytest.raises(br.core.InputError, match="the draws contain no parameter of lugre"):
        columns_of(
            dataclasses.replace(fitted, draws={"M": fitted.draws["M"]}),
            "friction",
            experiment,
            "vary",
        )
    with pytest.raises(br.core.InputError, match="the identification has no plant"):
        columns_of(dataclasses.replace(fitted, plant=None), "plant", experiment, "vary")


# --- the file --------------------------------------------------------------------------------------------------------


LOOPS = """
schema = 1
experiment = "loop.toml"
runs = 4
seed = 1
[vary]
"controller.k_p" = { log_uniform = ["40 1/s", "160 1/s"] }
"compare.stiff.controller.k_v" = { choice = ["2 N*s/mm", "4 N*s/mm"] }
[grid]
"reference.frequency" = ["1 Hz", "2 Hz"]
"run.delay" = [0, 2]
[keep]
metrics = ["following_error.rms", "stiff.effort.peak"]
"""


def test_a_study_states_varied_values_and_stored_metrics(bench):
    study = bench.study(LOOPS)
    assert study.count == 16
    assert "draws" not in study.origins
    assert study.units == {
        "controller.k_p": "1/s",
        "compare.stiff.controller.k_v": "N*s/m",
        "reference.frequency": "Hz",
        "run.delay": "",
    }
    assert [metric.column for metric in study.metrics] == [
        "plain.following_error.rms",
        "stiff.following_error.rms",
        "stiff.effort.peak",
    ]
    values = study.values(Block(0, 16))
    assert np.all((values["controller.k_p"] >= 40.0) & (values["controller.k_p"] <= 160.0))
    assert set(values["compare.stiff.controller.k_v"]) <= {2000.0, 4000.0}
    # Neighbours differ by the point of the grid, each draw is made at all of them.
    assert values["reference.frequency"][:5].tolist() == [1.0, 1.0, 2.0, 2.0, 1.0]
    assert len(set(values["controller.k_p"][:4])) == 1


def test_a_model_in_place_of_an_experiment_is_refused_with_the_right_command(bench):
    with pytest.raises(br.core.InputError, match=r"experiment: is missing.*file = .*model\.toml"):
        bench.study(change=('experiment = "rig.toml"', 'model = "model.toml"'))


CHANGES = {
    "misspelt": (("runs = 12", "rums = 12"), r"rums: unknown key.*Did you mean 'runs'"),
    "no experiment": (('experiment = "rig.toml"', ""), r"experiment: is missing"),
    "no file": (('"rig.toml"', '"rug.toml"'), r"rug\.toml"),
    "no runs": (("runs = 12", ""), r"runs: is missing.*Write runs = 1000"),
    "runs": (("runs = 12", "runs = 0"), r"runs: .*found 0, allowed a whole number, 1 to"),
    "seed": (("seed = 7", "seed = -1"), r"seed: .*found -1"),
    "sampling": (("seed = 7", 'seed = 7\nsampling = "sobel"'), r"sampling: .*Did you mean 'sobol'"),
    "parameter": (
        ("friction.F_C", "friction.F_c"),
        r"vary\.\"friction\.F_c\": .*Did you mean 'F_C'",
    ),
    "section": (("friction.F_C", "frition.F_C"), r"allowed a key below .*Did you mean 'friction'"),
    "unit": (('"1 N", "0.1 N"', '"1 mm", "0.1 N"'), r"friction\.F_C\"\.normal\[0\]"),
    "range": (('"0.8 kg", "1.2 kg"', '"-1 kg", "1.2 kg"'), r"uniform\[0\]: .*allowed"),
    "order": (('"0.8 kg", "1.2 kg"', '"1.2 kg", "0.8 kg"'), r"uniform\[1\]: must be above"),
    "deviation": (('"0.1 N"]', '"0 N"]'), r"normal\[1\]: must be positive"),
    "distribution": (
        ("normal", "normale"),
        r"normale: is not a distribution.*Did you mean 'normal'",
    ),
    "one number": (('normal = ["1 N", "0.1 N"]', "normal = [1.0]"), r"allowed two values"),
    "metric": (
        ("motion.peak_to_peak", "motion.peak_to_peek"),
        r"keep\.metrics\[0\]: .*Did you mean",
    ),
    "twice": (("[keep]", '[grid]\n"plant.M" = [1.0]\n[keep]'), r"varies a value twice"),
    "seed varied": (("plant.M", "friction.seed"), r"seed"),
    "traces": (
        ("[keep]", '[keep]\ntraces = "worst 3"'),
        r"keep\.traces: was removed.*Delete this key: bristle study FILE --run N",
    ),
    "not a power": (
        ("seed = 7", "seed = 7\nsobol_indices = true"),
        r"power of two.*Write runs = 8 or 16",
    ),
    "grid with indices": (
        ("[vary]", 'sobol_indices = true\n[grid]\n"effort.frequency" = ["1 Hz"]\n[vary]'),
        r"need values of \[vary\], and exclude \[grid\]",
    ),
    "results": (
        ('{ normal = ["1 N", "0.1 N"] }', '{ from = "none", draws = "bootstrap" }'),
        r"\.from: .*model\.toml",
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_invalid_entries_are_refused_with_place_and_advice(bench, name):
    change, pattern = CHANGES[name]
    with pytest.raises(br.core.InputError) as error:
        bench.study(change=change)
    assert str(error.value).startswith(str(bench.folder / "study.toml"))
    assert re.search(pattern, str(error.value)), str(error.value)


def test_a_study_without_variation_is_refused(bench):
    text = STUDY[: STUDY.index("[vary]")]
    with pytest.raises(br.core.InputError, match="all runs would be equal"):
        bench.study(text)


def test_a_loop_with_a_noisy_sensor_needs_no_varied_value(bench):
    study = bench.study('schema = 1\nexperiment = "loop.toml"\nruns = 3\nseed = 1\n')
    assert study.causes == ()
    assert study.experiment.variants[0].run.seeds == 1


def test_the_block_follows_from_the_study_alone(bench):
    plain = bench.study(block=("block = 4", ""))
    assert plain.block == bench.study(block=("block = 4", "")).block
    assert (
        read_study_file(
            bench.write(runs=("runs = 12", "runs = 100000"), block=("block = 4", ""))
        ).block
        > plain.block
    )
