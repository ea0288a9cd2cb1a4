"""The values of a run follow from the seed of the study and the number of the run."""

import numpy as np
import pytest
from scipy import stats
from tests.study.conftest import STUDY

from bristle.files.arrays import write_arrays
from bristle.files.model import read_model
from bristle.study.plan import SAMPLINGS, Block, Sampling, seed_of_run


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


def test_a_further_cause_leaves_random_draws_of_the_others_as_they_are():
    alone, beside = (Sampling("random", 3, names, 50) for names in (("a",), ("b", "a")))
    assert np.array_equal(alone.numbers(0, 50)[:, 0], beside.numbers(0, 50)[:, 1])
    assert abs(np.corrcoef(beside.numbers(0, 50).T)[0, 1]) < 0.4


def test_another_seed_draws_other_values():
    first, second = (Sampling("random", seed, ("a",), 50).numbers(0, 50) for seed in (3, 4))
    assert not np.any(first == second)


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


def test_distributions_have_the_moments_that_the_file_says(bench):
    study = bench.study(runs=("runs = 12", "runs = 20000"))
    values = study.values(Block(0, 20000))
    level, mass = values["friction.F_C"], values["plant.M"]
    assert level.mean() == pytest.approx(1.0, abs=0.003)
    assert level.std() == pytest.approx(0.1, rel=0.02)
    assert stats.normaltest(level).pvalue > 1e-3
    assert (mass.min(), mass.max()) == pytest.approx((0.8, 1.2), abs=1e-3)


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
    with pytest.raises(ValueError, match="the fit is of lugre, translational, and the experiment has coulomb_v"):
        bench.study(
            STUDY.replace('"friction.F_C" = { normal = ["1 N", "0.1 N"] }', '"friction" = { from = "results", draws = "bootstrap" }')
        )
