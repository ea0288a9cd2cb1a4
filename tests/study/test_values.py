"""The values of a run follow from the seed of the study and the number of the run."""

import dataclasses

import numpy as np
import pytest
from scipy import stats
from tests.study.conftest import STUDY

from bristle.core import InputError, Variable
from bristle.files import read_toml
from bristle.files.arrays import write_arrays
from bristle.files.experiment import read_experiment
from bristle.files.model import read_model
from bristle.study.plan import SAMPLINGS, Block, Sampling, seed_of_run
from bristle.study.values import Drawn, Joint, Target, columns_of, drawn_from, fitted_at, target_at


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
    draws = {"F_C": 1.0 + 0.05 * drawn[:, 0], "sigma_2": 0.4 + 0.02 * drawn[:, 1], "M": 1.0 + 0.01 * drawn[:, 2]}

    class Folder:
        def write(self, name, data):
            (folder / name).write_bytes(data)

    write_arrays(Folder(), "draws", draws)
    assert read_model(folder / "model.toml").friction.name == "lugre"
    return draws


def test_joint_draws_keep_the_correlations_of_the_fit(bench):
    draws = fit_in(bench.folder / "results")
    study = bench.study(
        STUDY.replace('"friction.F_C" = { normal = ["1 N", "0.1 N"] }', '"friction" = { from = "results", draws = "bootstrap" }')
        .replace('"plant.M" = { uniform = ["0.8 kg", "1.2 kg"] }', '"plant" = { from = "results", draws = "bootstrap" }')
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
        (bench.folder / "rig.toml").read_text().replace('"lugre"', '"coulomb_viscous"').split("F_S")[0]
        + 'F_v = "1 N*s/m"\n[effort]\nmodel = "constant"\nlevel = 2.0\n'
        + '[run]\nduration = "0.1 s"\nsample_time = "1 ms"\n'
    )
    with pytest.raises(ValueError, match=r"the identification has lugre .translational., but the experiment has coulomb_v"):
        bench.study(
            STUDY.replace('"friction.F_C" = { normal = ["1 N", "0.1 N"] }', '"friction" = { from = "results", draws = "bootstrap" }')
        )


def target(**changes):
    return Target("friction.F_C", Variable("force", "level", min=0.0), "translational", **changes)


@pytest.mark.parametrize(
    ("distribution", "numbers", "values"),
    [
        ("choice", (1.0, 2.0, 4.0), [1.0, 1.0, 2.0, 4.0, 4.0]),
        ("normal", (10.0, 2.0), [10.0 - 2.0 * 3.090232, 10.0 - 2.0 * 0.524401, 10.0, 10.0 + 2.0 * 0.524401, 10.0 + 2.0 * 3.090232]),
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
    joint = Joint("fit", {"a": np.array([1.0, 2.0, 3.0]), "b": np.array([[1, 1], [2, 2], [3, 3]])}, {})
    values = joint.values(np.array([0.0, 0.32, 0.34, 0.66, 0.68, 1.0]))
    assert values["a"].tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert values["b"][:, 0].tolist() == [1, 1, 2, 2, 3, 3]
    assert Drawn(target(), "choice", ("x", "y")).values(np.array([0.2, 1.0]))["friction.F_C"].tolist() == ["x", "y"]


def test_a_value_is_read_in_si_within_the_range():
    assert target().number("2 kN", "") == 2000.0
    assert target(is_whole=True).number(3.0, "") == 3.0
    with pytest.raises(InputError, match="must be a whole number"):
        target(is_whole=True).number(2.5, "")
    with pytest.raises(InputError, match=r"a\[1\]"):
        target().numbers(["1 N", "-1 N"], "a")
    named = Target("reference.model", Variable("1", "shape", choices=("round", "square")), "translational")
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
        ({"log_uniform": [0.0, 2.0]}, r"log_uniform\[0\]: must be positive, because log_uniform takes its logarithm"),
    ],
)
def test_a_distribution_that_does_not_fit_is_reported(table, words):
    with pytest.raises(InputError, match=words):
        drawn_from(table, target(), "vary")


def test_distributions_that_fit_are_read():
    assert drawn_from({"choice": [1.0]}, target(), "").numbers == (1.0,)
    assert drawn_from({"normal": ["1 kN", "1 N"]}, target(), "").numbers == (1000.0, 1.0)
    assert drawn_from({"log_uniform": [1.0, 2.0]}, target(), "").distribution == "log_uniform"
    assert drawn_from({"choice": [1.0, 2.0, 3.0]}, target(is_whole=True), "").numbers == (1.0, 2.0, 3.0)
    with pytest.raises(InputError, match="a continuous quantity"):
        drawn_from({"uniform": [1.0, 2.0]}, target(is_whole=True), "")


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("friction.seed", r"is a seed, which \[vary\] cannot contain"),
        ("run.seeds", r"is a seed, which \[vary\] cannot contain"),
        ("compare.none.friction.F_C", r"is not a variant.*compare\.plain\.…, compare\.stiff\.…"),
        ("compare.plain.friction", "is not a variant"),
        ("sensor.noises", r"is not a value of this experiment.*allowed sensor\..*Did you mean 'noise'"),
    ],
)
def test_a_key_that_is_not_varied_is_reported(bench, key, words):
    experiment, (data, *_) = read_experiment(bench.folder / "loop.toml"), read_toml(bench.folder / "loop.toml")
    with pytest.raises(InputError, match=words) as error:
        target_at(key, experiment, data, "vary")
    assert "seed" not in str(error.value).partition("allowed")[2]


def test_a_key_is_a_value_with_the_unit_and_whether_steps_are_whole(bench):
    experiment, (data, *_) = read_experiment(bench.folder / "loop.toml"), read_toml(bench.folder / "loop.toml")
    result = {key: target_at(key, experiment, data, "") for key in ("run.delay", "compare.stiff.controller.k_v", "sensor.noise")}
    assert [(item.unit, item.is_whole) for item in result.values()] == [("", True), ("N*s/m", False), ("m", False)]
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
    with pytest.raises(InputError, match=words):
        fitted_at(table, tmp_path, "vary.friction")


def test_a_fit_without_draws_is_reported(bench):
    fit_in(bench.folder / "results")
    (file,) = (bench.folder / "results").glob("draws.*")
    fitted = fitted_at(FROM, bench.folder, "vary")
    assert (fitted.folder, fitted.friction.name, fitted.origin.name) == ("results", "lugre", file.name)
    file.unlink()
    with pytest.raises(InputError, match=r"names results without draws.*--draws 1000"):
        fitted_at(FROM, bench.folder, "vary")


def test_draws_go_to_the_section_whose_parameters_they_are(bench):
    draws = fit_in(bench.folder / "results")
    fitted, experiment = fitted_at(FROM, bench.folder, "vary"), read_experiment(bench.folder / "rig.toml")
    columns, units = columns_of(fitted, "friction", experiment, "vary")
    assert units == {"friction.F_C": "N", "friction.sigma_2": "N*s/m"}
    assert columns["friction.F_C"].tolist() == draws["F_C"].tolist()
    shorter = dataclasses.replace(fitted, draws=fitted.draws | {"M": fitted.draws["M"][:7]})
    assert columns_of(shorter, "friction", experiment, "vary")[0]["friction.F_C"].size == 7
    with pytest.raises(InputError, match=r"cannot use draws of an identification.*plant or friction"):
        columns_of(fitted, "sensor", experiment, "vary")
    with pytest.raises(InputError, match="the draws contain no parameter of lugre"):
        columns_of(dataclasses.replace(fitted, draws={"M": fitted.draws["M"]}), "friction", experiment, "vary")
    with pytest.raises(InputError, match="the identification has no plant"):
        columns_of(dataclasses.replace(fitted, plant=None), "plant", experiment, "vary")
