"""What is kept of a run is what ``simulate`` returns of it, whichever way it was simulated."""

import numpy as np
import pytest
from tests.study.conftest import STUDY, content, same

import bristle as br
from bristle.core.errors import InputError
from bristle.engine.batch import _Batch
from bristle.files.summary import as_json
from bristle.report.simulation import simulation_summary
from bristle.study import run_study
from bristle.study.block import Simulator, Varied, row_of
from bristle.study.plan import METRICS, Block
from bristle.study.run import repeat_run, values_of

EVERY = STUDY[: STUDY.index("metrics")] + f"metrics = {list(METRICS)!r}\n".replace("'", '"')
LOOPS = """
schema = 1
experiment = "loop.toml"
runs = 3
seed = 1
[vary]
"controller.k_p" = { uniform = ["60 1/s", "100 1/s"] }
"friction.F_C" = { uniform = ["6 N", "10 N"] }
"plant.M" = { uniform = ["19 kg", "21 kg"] }
[grid]
"reference.frequency" = ["1 Hz", "2 Hz"]
"""


def test_runs_in_a_batch_have_the_bits_of_runs_one_by_one(bench):
    study = bench.study(EVERY)
    batch, serial = Simulator(study), Simulator(study, batches=False)
    assert batch.in_batches
    assert not serial.in_batches
    block = Block(1, 9)
    first, second = batch.columns(block), serial.columns(block)
    assert same(first, second)
    assert len(set(first["motion.std"])) == 8
    assert np.all(np.isnan(first["following_error.rms"]))


@pytest.mark.slow
def test_runs_in_lanes_have_the_bits_of_runs_one_by_one(bench, monkeypatch):
    monkeypatch.setattr("bristle.study.block.WORTH_LANES", 0)
    bench.rig(substeps=1)
    study = bench.study(EVERY, runs=("runs = 12", "runs = 64"), block=("block = 4", "block = 40"))
    in_lanes = []
    monkeypatch.setattr("bristle.engine.batch._Batch.in_lanes", lambda *a, of=_Batch.in_lanes: in_lanes.append(a) or of(*a))
    block = Block(1, 41)
    assert same(Simulator(study).columns(block), Simulator(study, batches=False).columns(block))
    assert len(in_lanes) == 1


@pytest.mark.slow
def test_threads_write_the_same_bytes_as_workers_and_start_no_worker(bench, monkeypatch):
    study = bench.study(EVERY)
    run_study(study, bench.folder / "workers", workers=2)
    with monkeypatch.context() as without:
        without.setattr("bristle.study.run.Crew", None)
        assert run_study(study, bench.folder / "threads").is_whole
    assert content(bench.folder / "threads") == content(bench.folder / "workers")
    assert len(content(bench.folder / "threads")) == 3


@pytest.mark.parametrize(("model", "drawn"), [("lugre", "0.2 N"), ("elastoplastic", "0.8 N")])
def test_only_draws_out_of_range_leave_the_batch(bench, model, drawn):
    rig = (bench.folder / "rig.toml").read_text()
    if model == "elastoplastic":  # whose sigma_0 z_ba must be below F_C
        rig = rig.replace('model = "lugre"', 'model = "elastoplastic"\nz_ba = "8 um"')
    (bench.folder / "rig.toml").write_text(rig)
    study = bench.study(normal=('["1 N", "0.1 N"]', f'["{drawn}", "0.2 N"]'))  # F_C may be negative
    block = Block(0, 12)
    values, varied = study.values(block), Varied(study)
    models = varied.models_by_place(values, study.seeds(block), ("plant", "friction"))
    refused = set()
    for place in range(12):
        try:
            alone = varied.models(row_of(values, place), study.seeds(block)[place], ("plant", "friction"))
        except InputError:
            refused.add(place)
        else:
            assert models[place] == alone
    assert refused
    assert set(models) == set(range(12)) - refused


def test_values_set_in_models_make_the_experiment_that_the_file_would(bench):
    study = bench.study(LOOPS)
    direct, by_tables = Varied(study), Varied(study)
    by_tables._direct = None
    assert direct.is_direct
    for number in range(study.count):
        block = Block(number, number + 1)
        values, seed = row_of(study.values(block), 0), study.seeds(block)[0]
        first, second = (br.simulate(way.experiment(values, seed)) for way in (direct, by_tables))
        for name in ("plain", "stiff"):
            assert first.variants[name].measured.tobytes() == second.variants[name].measured.tobytes()


def test_a_variant_keeps_its_overridden_value(bench):
    study = bench.study(LOOPS)
    values = row_of(study.values(Block(0, 1)), 0)
    plain, stiff = Varied(study).experiment(values, 1).variants
    assert plain.controller.values["k_p"] == values["controller.k_p"]
    assert stiff.controller.values["k_p"] == 120.0
    assert stiff.friction.values["F_C"] == values["friction.F_C"]


def test_values_that_reach_further_than_one_model_go_through_the_tables(bench):
    study = bench.study(LOOPS.replace('"reference.frequency" = ["1 Hz", "2 Hz"]', '"run.delay" = [0, 1]'))
    varied = Varied(study)
    assert not varied.is_direct
    experiment = varied.experiment(row_of(study.values(Block(1, 2)), 0), 1)
    assert [variant.run.delay for variant in experiment.variants] == [1, 1]
    assert [variant.run.seeds for variant in experiment.variants] == [1, 1]


def test_gravity_that_is_fed_forward_is_that_of_the_plant_of_the_run(bench):
    loop = (bench.folder / "loop.toml").read_text()
    loop = loop.replace('[plant]\nM = "20 kg"', '[plant]\nmodel = "inertia+gravity"\nM = "20 kg"\ng_sin = "100 N"')
    loop = loop.replace("[sensor]", '[controller.feedforward]\nplant = "own"\n[sensor]')
    (bench.folder / "loop.toml").write_text(loop)
    varied = Varied(bench.study(LOOPS))
    values = row_of(varied.study.values(Block(0, 1)), 0)
    assert not varied.is_direct
    assert varied.experiment(values, 1).variants[0].feedforward.plant.values["M"] == values["plant.M"]


def test_the_seed_of_a_run_is_added_to_those_of_the_file(bench):
    study = bench.study(LOOPS)
    values = row_of(study.values(Block(0, 1)), 0)
    first, second = (Varied(study).experiment(values, seed).variants[0].sensor.values["seed"] for seed in (0, 40))
    assert (first, second) == (5, 45)


def test_a_run_repeated_has_the_numbers_that_were_kept(bench):
    study = bench.study(LOOPS)
    kept = Simulator(study).columns(Block(0, study.count))
    result = repeat_run(study, 4)
    assert kept["stiff.effort.rms"][4] == result.variants["stiff"].effort_rms
    assert kept["controller.k_p"][4] == values_of(study, 4)["controller.k_p"]
    with pytest.raises(br.core.InputError, match="0 to 5"):
        repeat_run(study, 6)


def test_a_diverged_loop_has_no_numbers(bench):
    loop = (bench.folder / "loop.toml").read_text().replace('limit = "300 N"\n', "").replace('"0.2 s"', '"2 s"')
    (bench.folder / "loop.toml").write_text(loop)
    fast = LOOPS.replace('["60 1/s", "100 1/s"]', '["6e5 1/s", "7e5 1/s"]')
    study = bench.study(fast.replace("[grid]", '[grid]\n"run.delay" = [20]'))
    columns = Simulator(study).columns(Block(0, 1))
    assert columns["status"] == ["not_finite"]
    assert np.isnan(columns["plain.effort.rms"][0])
    assert "plain" in columns["reason"][0]


def test_every_metric_is_a_number_of_bristle_run(bench):
    result = br.simulate(bench.folder / "loop.toml")
    variant = simulation_summary(result, files={}, provenance={})["variants"]["plain"]
    assert as_json(variant)
    for name in METRICS:
        entry = variant
        for key in name.split("."):
            entry = entry[key]
        assert isinstance(entry, float)
