"""What a study file may say, and how it is told where it does not fit."""

import re

import numpy as np
import pytest
from tests.study.conftest import STUDY

from bristle.core.errors import InputError
from bristle.study import read_study_file
from bristle.study.plan import Block

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
    assert study.units == {"controller.k_p": "1/s", "compare.stiff.controller.k_v": "N*s/m", "reference.frequency": "Hz", "run.delay": ""}
    assert [metric.column for metric in study.metrics] == ["plain.following_error.rms", "stiff.following_error.rms", "stiff.effort.peak"]
    values = study.values(Block(0, 16))
    assert np.all((values["controller.k_p"] >= 40.0) & (values["controller.k_p"] <= 160.0))
    assert set(values["compare.stiff.controller.k_v"]) <= {2000.0, 4000.0}
    # Neighbours differ by the point of the grid, each draw is made at all of them.
    assert values["reference.frequency"][:5].tolist() == [1.0, 1.0, 2.0, 2.0, 1.0]
    assert len(set(values["controller.k_p"][:4])) == 1


def test_a_model_in_place_of_an_experiment_is_refused_with_the_right_command(bench):
    with pytest.raises(InputError, match=r"experiment: is missing.*file = .*model\.toml"):
        bench.study(change=('experiment = "rig.toml"', 'model = "model.toml"'))


CHANGES = {
    "misspelt": (("runs = 12", "rums = 12"), r"rums: unknown key.*Did you mean 'runs'"),
    "no experiment": (('experiment = "rig.toml"', ""), r"experiment: is missing"),
    "no file": (('"rig.toml"', '"rug.toml"'), r"rug\.toml"),
    "no runs": (("runs = 12", ""), r"runs: is missing.*Write runs = 1000"),
    "runs": (("runs = 12", "runs = 0"), r"runs: .*found 0, allowed a whole number, 1 to"),
    "seed": (("seed = 7", "seed = -1"), r"seed: .*found -1"),
    "sampling": (("seed = 7", 'seed = 7\nsampling = "sobel"'), r"sampling: .*Did you mean 'sobol'"),
    "parameter": (("friction.F_C", "friction.F_c"), r"vary\.\"friction\.F_c\": .*Did you mean 'F_C'"),
    "section": (("friction.F_C", "frition.F_C"), r"allowed a key below .*Did you mean 'friction'"),
    "unit": (('"1 N", "0.1 N"', '"1 mm", "0.1 N"'), r"friction\.F_C\"\.normal\[0\]"),
    "range": (('"0.8 kg", "1.2 kg"', '"-1 kg", "1.2 kg"'), r"uniform\[0\]: .*allowed"),
    "order": (('"0.8 kg", "1.2 kg"', '"1.2 kg", "0.8 kg"'), r"uniform\[1\]: must be above"),
    "deviation": (('"0.1 N"]', '"0 N"]'), r"normal\[1\]: must be positive"),
    "distribution": (("normal", "normale"), r"normale: is not a distribution.*Did you mean 'normal'"),
    "one number": (('normal = ["1 N", "0.1 N"]', "normal = [1.0]"), r"allowed two values"),
    "metric": (("motion.peak_to_peak", "motion.peak_to_peek"), r"keep\.metrics\[0\]: .*Did you mean"),
    "twice": (("[keep]", '[grid]\n"plant.M" = [1.0]\n[keep]'), r"varies a value twice"),
    "seed varied": (("plant.M", "friction.seed"), r"seed"),
    "traces": (("[keep]", '[keep]\ntraces = "worst 3"'), r"keep\.traces: was removed.*Delete this key: bristle study FILE --run N"),
    "not a power": (("seed = 7", "seed = 7\nsobol_indices = true"), r"power of two.*Write runs = 8 or 16"),
    "grid with indices": (
        ("[vary]", 'sobol_indices = true\n[grid]\n"effort.frequency" = ["1 Hz"]\n[vary]'),
        r"need values of \[vary\], and exclude \[grid\]",
    ),
    "results": (('{ normal = ["1 N", "0.1 N"] }', '{ from = "none", draws = "bootstrap" }'), r"\.from: .*model\.toml"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_invalid_entries_are_refused_with_place_and_advice(bench, name):
    change, pattern = CHANGES[name]
    with pytest.raises(InputError) as error:
        bench.study(change=change)
    assert str(error.value).startswith(str(bench.folder / "study.toml"))
    assert re.search(pattern, str(error.value)), str(error.value)


def test_a_study_without_variation_is_refused(bench):
    text = STUDY[: STUDY.index("[vary]")]
    with pytest.raises(InputError, match="all runs would be equal"):
        bench.study(text)


def test_a_loop_with_a_noisy_sensor_needs_no_varied_value(bench):
    study = bench.study('schema = 1\nexperiment = "loop.toml"\nruns = 3\nseed = 1\n')
    assert study.causes == ()
    assert study.experiment.variants[0].run.seeds == 1


def test_the_block_follows_from_the_study_alone(bench):
    plain = bench.study(block=("block = 4", ""))
    assert plain.block == bench.study(block=("block = 4", "")).block
    assert read_study_file(bench.write(runs=("runs = 12", "runs = 100000"), block=("block = 4", ""))).block > plain.block
