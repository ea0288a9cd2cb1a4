"""Open loops in experiment files: what drives them, how long, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from bristle.cli.main import main
from bristle.core import InputError
from bristle.files.experiment import read_experiment

OPEN = """
schema = 1
[plant]
model = "pulled_inertia"
M = "1 kg"
k = "2 N/m"
v_e = "0.2 m/s"
[friction]
model = "coulomb"
F_C = "1 N"
[effort]
model = "constant"
[run]
duration = "6 s"
sample_time = "10 ms"
tolerance = "1 um"
"""
LOG = (
    "time [s],position [m],effort [N]\n"
    + "\n".join(f"{0.02 * k:.2f},{1e-3 * k:.3f},{np.sin(k):.6f}" for k in range(120))
    + "\n"
)


def write(folder, text):
    (folder / "experiment.toml").write_text(text)
    return folder / "experiment.toml"


def read(folder, text):
    (variant, *_) = read_experiment(write(folder, text)).variants
    return variant


def test_a_plant_left_alone(tmp_path):
    variant = read(tmp_path, OPEN)
    assert (variant.effort.values.tolist(), variant.effort.description) == ([0.0] * 600, "none")
    assert (variant.run.tolerance, variant.run.substeps) == (1e-6, 0)


@pytest.mark.parametrize(
    ("table", "check"),
    [
        ('model = "constant"\nlevel = "3 N"', lambda u, t: np.ptp(u) == 0.0 and u[0] == 3.0),
        (
            'model = "sine"\namplitude = "2 kN"\nfrequency = "2 Hz"',
            lambda u, t: np.allclose(u, 2e3 * np.sin(4.0 * np.pi * t)),
        ),
        (
            'model = "s_curve"\ndistance = "5 N"\nvelocity = "2 N/s"\nacceleration = "1 kN/s^2"',
            lambda u, t: u[-1] == pytest.approx(5.0) and np.max(np.diff(u)) == pytest.approx(0.02),
        ),
    ],
)
def test_functions_of_time_are_efforts(tmp_path, table, check):
    variant = read(tmp_path, OPEN.replace('model = "constant"', table))
    assert check(variant.effort.values, 0.01 * np.arange(600))
    assert variant.effort.description.startswith(table.split('"')[1])


def test_the_effort_of_a_log_sets_the_duration_with_zero_order_hold(tmp_path):
    (tmp_path / "log.csv").write_text(LOG)
    text = OPEN.replace('model = "constant"', 'model = "recorded"\nfile = "log.csv"').replace(
        'duration = "6 s"', ""
    )
    finer = read(tmp_path, text)
    assert finer.run.duration == pytest.approx(2.4)
    assert finer.effort.values.reshape(-1, 2).tolist() == [
        [round(float(np.sin(k)), 6)] * 2 for k in range(120)
    ]
    alike = read(tmp_path, text.replace('sample_time = "10 ms"', ""))
    assert alike.effort.values.tolist() == finer.effort.values[::2].tolist()


def test_variants_differ_in_their_efforts(tmp_path):
    text = OPEN + '[compare.still]\n[compare.pushed.effort]\nlevel = "1 N"\n'
    still, pushed = read_experiment(write(tmp_path, text)).variants
    assert (still.effort.values[0], pushed.effort.values[0]) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[run]", "[run]\nsubsteps = 4", "run.substeps: .*tolerance.*Remove substeps or tolerance"),
        ("[run]", "[run]\ndelay = 1", "run.delay: conflicts with the tolerance.*substeps"),
        (
            "[run]",
            '[run]\ncurrent_lag = "1 ms"',
            "run.current_lag: conflicts with the tolerance.*substeps",
        ),
        (
            "[run]",
            '[controller]\nmodel = "cascade"\n[run]',
            r"controller: needs a closed loop.*\[effort\]",
        ),
        ("[run]", '[reference]\nmodel = "sine"\n[run]', "reference: needs a closed loop"),
        ('tolerance = "1 um"', 'tolerance = "-1 um"', "run.tolerance: "),
        ('tolerance = "1 um"', 'tolerance = "1 N"', "run.tolerance: "),
        ('model = "constant"', 'level = "1 N"', "effort: names no model.*constant, sine"),
        ('model = "constant"', 'model = "sin"', "effort.model: .*sin.*sine"),
        (
            'model = "constant"',
            'model = "constant"\namplitude = 1',
            "effort.amplitude: unknown key.*level",
        ),
        ('model = "constant"', 'model = "sine"\namplitude = "2 mm"', "effort.amplitude: .*2 mm"),
        ('model = "constant"', 'model = "sine"\namplitude = "2 N"', "frequency"),
        ('model = "constant"', 'model = "recorded"', "effort.file: "),
        (
            'model = "constant"',
            'model = "recorded"\nfile = "log.csv"',
            r"run\.duration: is longer than the log of the effort, 2\.4 s",
        ),
        (
            '[effort]\nmodel = "constant"',
            '[controller]\nmodel = "cascade"\nk_p = 10\nk_v = 20\n[reference]\nmodel = "sine"\namplitude = "1 mm"\nfrequency = 1',
            r"run.tolerance: is only for open loops with \[effort\]",
        ),
    ],
)
def test_conflicting_keys_are_refused(tmp_path, old, new, message):
    (tmp_path / "log.csv").write_text(LOG)
    with pytest.raises(InputError, match=message):
        read(tmp_path, OPEN.replace(old, new))


@pytest.mark.slow
def test_the_command_runs_it_and_reports_it(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(write(tmp_path, OPEN)), "--out", str(out), "--log"]) == 0
    text = capsys.readouterr().out
    assert "Position, peak to peak" in text
    assert "ollowing error" not in text
    numbers = json.loads((out / "summary.json").read_text())["variants"]["base"]
    assert (
        numbers["completed"],
        numbers["motion"]["max"] > 0.1,
        numbers["following_error"]["rms"],
    ) == (True, True, None)
    page = Path(out / "report.html").read_text()
    assert "An open loop: without a controller" in page
    assert "1 µm" in page.replace("\u202f", " ").replace("\xa0", " ")
    assert (out / "log.csv").read_text().splitlines()[0] == "time [s],position [m],effort [N]"


@pytest.mark.parametrize(
    "effort", ['model = "constant"\nlevel = "0.3 N*m"', 'model = "recorded"\nfile = "log.csv"']
)
def test_an_open_loop_that_turns_has_a_reference_that_turns(tmp_path, effort):
    (tmp_path / "log.csv").write_text(LOG.replace("[m]", "[rad]").replace("[N]", "[N*m]"))
    text = f"""
        schema = 1
        kind = "rotational"
        [plant]
        model = "inertia"
        M = "0.1 kg*m^2"
        [friction]
        model = "coulomb"
        F_C = "0.1 N*m"
        [effort]
        {effort}
        [run]
        {'duration = "1 s"' if "constant" in effort else ""}
        sample_time = "10 ms"
    """
    variant = read(tmp_path, text)
    assert variant.reference.kind == variant.plant.kind == "rotational"
