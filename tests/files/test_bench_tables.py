"""Tables of the bench in experiment files: what is fed forward, what is learned, noise and several runs."""

import math

import pytest

from bristle.core.errors import InputError
from bristle.files.experiment import read_experiment
from bristle.simulation import simulate

HEAD = """
schema = 1

[plant]
M = "3 kg"

[friction]
model = "maxwell_stribeck"
F_C = "2 N"
F_S = "3 N"
v_S = "1 mm/s"
k_i = ["0.2 N/um", "0.1 N/um"]
nu_i = [0.5, 0.5]
scatter = 0.05

[sensor]
resolution = "0.1 um"
noise = "0.05 um"

[reference]
model = "varied_sine"
amplitudes = ["0 um", "500 um", "200 um"]
frequency = "2 Hz"
duration = "1 s"

[run]
duration = "1 s"
sample_time = "1 ms"
substeps = 4
current_lag = "0.3 ms"
seeds = 3

[controller]
model = "sliding_mode"
J = "3 kg"
lambda = "100 1/s"
K_1 = "100 1/s"
cutoff = "200 Hz"
"""
FED = """
[controller.feedforward]
friction = { model = "preisach_contact", s = "0.3 N/um", f_p = "4 N" }
gain = 0.9
offset = "0.2 N"
asymmetry = 0.1
limit = "3 N"
rate_limit = "2 N/ms"
conditioning = "60 um"
along = "measured"
"""
LEARNED = """
[controller.learning]
trials = 3
k_e = "30 N/mm"
k_d = "0.6 N*s/mm"
cutoff = "20 Hz"
"""


def read(tmp_path, text):
    path = tmp_path / "experiment.toml"
    path.write_text(text)
    return read_experiment(path)


def test_feedforward_is_read_with_its_units(tmp_path):
    fed = read(tmp_path, HEAD + FED).variants[0].feedforward
    assert (fed.gain, fed.offset, fed.asymmetry, fed.limit, fed.along) == (
        0.9,
        0.2,
        0.1,
        3.0,
        "measured",
    )
    assert (fed.rate_limit, fed.conditioning) == pytest.approx((2000.0, 60e-6))
    plain = read(tmp_path, HEAD).variants[0].feedforward
    assert (plain.friction, plain.along, plain.limit) == (None, "desired", math.inf)


def test_several_runs_are_reported_as_means_with_their_spread(tmp_path):
    result = simulate(read(tmp_path, HEAD)).variants["base"]
    singles = [
        simulate(
            read(
                tmp_path,
                HEAD.replace("seeds = 3", "")
                .replace("scatter = 0.05", f"scatter = 0.05\nseed = {seed}")
                .replace('noise = "0.05 um"', f'noise = "0.05 um"\nseed = {seed}'),
            )
        ).variants["base"]
        for seed in range(3)
    ]
    peaks = [single.following_error.peak_to_peak for single in singles]
    assert len(set(peaks)) == 3
    assert result.following_error.peak_to_peak == pytest.approx(sum(peaks) / 3)
    message = result.as_dict()
    assert message["following_error"]["peak_to_peak_spread"] == pytest.approx(
        math.sqrt(sum((single - sum(peaks) / 3) ** 2 for single in peaks) / 2)
    )
    assert "peak_to_peak_spread" not in singles[0].as_dict()["following_error"]


def test_a_motion_is_learned_over_its_trials(tmp_path):
    result = simulate(read(tmp_path, HEAD + LEARNED)).variants["base"]
    assert len(result.as_dict()["trials"]) == 3
    assert result.trials[-1] < 0.5 * result.trials[0]


@pytest.mark.parametrize(
    ("told", "instead", "words"),
    [
        (
            'along = "measured"',
            'along = "both"',
            r"controller\.feedforward\.along.*'both'.*desired or measured",
        ),
        ("asymmetry = 0.1", "asymmetry = 1.5", r"controller\.feedforward\.asymmetry.*-1 to 1"),
        ('limit = "3 N"', 'limit = "3 mm"', r"controller\.feedforward\.limit.*N"),
        ("gain = 0.9", "gian = 0.9", r"controller\.feedforward\.gian.*gain"),
        ("seeds = 3", "seeds = 2.5", r"run\.seeds.*whole number"),
        ("seeds = 3", "seeds = 0", r"run\.seeds"),
        ('current_lag = "0.3 ms"', 'current_lag = "-1 ms"', r"run\.current_lag.*>= 0 s"),
        ('noise = "0.05 um"', 'noise = "-1 um"', r"sensor\.noise"),
        ("trials = 3", "trials = 2.5", r"controller\.learning\.trials.*whole number"),
        ('cutoff = "20 Hz"\n', "", r"controller\.learning.*needs cutoff"),
        ('lambda = "100 1/s"', 'lambda_ = "100 1/s"', r"controller\.lambda_.*lambda"),
        (
            'amplitudes = ["0 um", "500 um", "200 um"]',
            'amplitudes = ["0 um"]',
            "at least 2 amplitudes",
        ),
    ],
)
def test_invalid_values_are_refused_with_their_place(tmp_path, told, instead, words):
    text = HEAD + FED + LEARNED
    assert told in text
    with pytest.raises(InputError, match=words):
        read(tmp_path, text.replace(told, instead, 1))


def test_a_filter_faster_than_the_samples_is_refused(tmp_path):
    experiment = read(tmp_path, HEAD + LEARNED.replace("20 Hz", "600 Hz"))
    with pytest.raises(InputError, match=r"learning\.cutoff.*500 Hz"):
        simulate(experiment)
