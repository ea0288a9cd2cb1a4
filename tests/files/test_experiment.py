"""Experiment files: variants, what is taken from other files, and what is refused."""

import re

import numpy as np
import pytest

from bristle.core import InputError
from bristle.core.errors import InputWarning
from bristle.files.experiment import Planned, read_experiment
from bristle.files.results import results_folder

PLAIN = """
schema = 1
name = "plain"

[plant]
M = "2 kg"

[friction]
model = "coulomb_viscous"
F_C = "3 N"
F_v = 4

[controller]
model = "cascade"
k_p = 10
k_v = 20

[controller.feedforward]
mass = "2 kg"
gain = 0.9
friction = { model = "coulomb", F_C = "2.5 N" }

[reference]
model = "sine"
amplitude = "1 mm"
frequency = 1

[run]
duration = "2 s"
sample_time = "1 ms"
"""
AXIS = """
schema = 1
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "m" }
reference = { column = "r", unit = "mm" }
effort = { column = "u", unit = "V" }

[effort]
force_constant = "5 N/V"
limit = "10 V"

[encoder]
resolution = "2 um"

[plant]
mass = "7 kg"

[controller]
model = "cascade"
k_p = 10
k_v = "4 V*s/m"
"""
BY_AXIS = """
schema = 1

[axis]
file = "axis.toml"

[friction]
model = "coulomb"
F_C = "3 N"

[reference]
model = "recorded"
file = "log.csv"
"""


@pytest.fixture
def experiment(tmp_path):
    """Return what writes an experiment file, with the files that it may name beside it, and reads it."""
    (tmp_path / "axis.toml").write_text(AXIS)
    t = 1e-3 * np.arange(200)
    columns = np.column_stack((t, np.sin(9 * t), 1e3 * np.sin(9 * t), np.cos(9 * t)))
    np.savetxt(
        tmp_path / "log.csv", columns, delimiter=",", header="t,q,r,u", comments="", fmt="%.15g"
    )

    def read(text: str, *, allow_code: bool = False, **rest: str):
        for name, content in rest.items():
            (tmp_path / f"{name}.toml").write_text(content)
        path = tmp_path / "experiment.toml"
        path.write_text(text)
        return read_experiment(path, allow_code=allow_code)

    return read


def test_a_file_without_variants_is_a_single_variant(experiment):
    result = experiment(PLAIN)
    (base,) = result.variants
    assert (result.name, result.kind, base.name) == ("plain", "translational", "base")
    assert (base.plant.values, base.friction.values) == (
        {"M": 2.0},
        {"F_C": 3.0, "F_v": 4.0, "offset": 0.0},
    )
    assert (
        base.feedforward.mass,
        base.feedforward.gain,
        base.feedforward.friction.values["F_C"],
    ) == (2.0, 0.9, 2.5)
    assert base.sensor.values["resolution"] == 0.0
    assert (base.run.duration, base.run.sample_time, base.run.substeps, base.run.delay) == (
        2.0,
        1e-3,
        4,
        0,
    )


def test_variants_change_only_the_keys_that_they_name(experiment):
    result = experiment(
        PLAIN
        + """
[compare.none.controller.feedforward]
friction = "none"
[compare.late.run]
delay = 2
[compare.stribeck]
friction = { model = "stribeck", F_C = 3, F_S = 5, v_S = "1 mm/s", F_v = 4 }
"""
    )
    base, none, late, stribeck = result.variants
    assert [variant.name for variant in result.variants] == ["base", "none", "late", "stribeck"]
    assert (none.feedforward.friction, none.feedforward.mass, none.friction) == (
        None,
        2.0,
        base.friction,
    )
    assert (late.run.delay, late.run.duration) == (2, 2.0)
    assert (stribeck.friction.name, stribeck.friction.values["v_S"], stribeck.controller) == (
        "stribeck",
        1e-3,
        base.controller,
    )


def test_an_empty_variant_renames_the_base(experiment):
    result = experiment(
        PLAIN + '[compare.with]\n[compare.without.controller.feedforward]\nfriction = "none"\n'
    )
    assert [variant.name for variant in result.variants] == ["with", "without"]
    assert result.variants[0].feedforward.friction is not None


def test_an_axis_provides_missing_values(experiment):
    (base,) = experiment(BY_AXIS).variants
    assert (base.plant.values, base.sensor.values["resolution"]) == ({"M": 7.0}, 2e-6)
    assert base.controller.values["k_v"] == 20.0  # 4 V*s/m at 5 N/V
    assert (base.run.effort_limit, base.run.sample_time, base.run.duration) == (
        50.0,
        pytest.approx(1e-3, rel=1e-12),
        pytest.approx(0.2),
    )
    assert base.reference.values["position"][100] == pytest.approx(np.sin(0.9), rel=1e-12)
    changed = experiment(
        BY_AXIS + '[plant]\nM = 8\n[controller]\nk_p = 30\n[run]\neffort_limit = "4 V"\n'
    ).variants[0]
    assert (changed.plant.values, changed.run.effort_limit) == ({"M": 8.0}, 20.0)
    assert (changed.controller.values["k_p"], changed.controller.values["k_v"]) == (30.0, 20.0)


IDENTIFIED = """
schema = 1
kind = "rotational"
[plant]
model = "inertia"
M = 0.5
[friction]
model = "coulomb+asymmetry"
F_C_pos = 1.0
F_C_neg = 2.0
"""
BY_MODEL = """
schema = 1
[friction]
file = "model.toml"
[controller]
model = "cascade"
k_p = 10
k_v = 20
[controller.feedforward]
friction = { file = "model.toml", F_C_neg = "1.5 N*m" }
[reference]
model = "sine"
amplitude = "1 deg"
frequency = 1
[run]
duration = 1
sample_time = 1e-3
"""


def test_an_identified_model_gives_plant_kind_and_friction(experiment):
    result = experiment(BY_MODEL, model=IDENTIFIED)
    (base,) = result.variants
    assert (result.kind, base.plant.values) == ("rotational", {"M": 0.5})
    fed = base.feedforward.friction.values
    assert (base.friction.values["F_C_neg"], fed["F_C_neg"], fed["F_C_pos"]) == (2.0, 1.5, 1.0)
    assert base.reference.values["amplitude"] == pytest.approx(np.pi / 180)


def test_a_users_own_model_by_file(experiment, own_model):
    text = PLAIN.replace(
        'model = "coulomb_viscous"\nF_C = "3 N"\nF_v = 4',
        'file = "own.py"\nF_0 = "3 N"\nlambda = 0.5',
    )
    with pytest.raises(InputError, match="needs permission to run"):
        experiment(text)
    with pytest.warns(InputWarning, match="is run"):
        result = experiment(text, allow_code=True)
    assert [origin.name for origin in result.origins["code"]] == ["own.py"]
    (base,) = result.variants
    assert base.friction.values == {"F_0": 3.0, "lambda_": 0.5, "offset": 0.0}


def test_the_kind_follows_from_the_units(experiment):
    text = (
        PLAIN.replace('"2 kg"', "2")
        .replace('"3 N"', '"3 N*m"')
        .replace('"2.5 N"', '"2.5 N*m"')
        .replace("1 mm", "1 mrad")
    )
    assert experiment(text).kind == "rotational"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PLAIN.replace("schema = 1", ""), ("schema",)),
        (PLAIN.replace('"plain"', "3"), ("name", "text")),
        (PLAIN + "[compare]\nnone = 1\n", ("compare.none", "table")),
        (PLAIN + "[compare.one]\nname = 'x'\n", ("compare.one.name",)),
        (PLAIN + "[compare.one.friction]\nF_C = -3\n", ("compare.one.friction.F_C", ">= 0 N")),
        (PLAIN + "[compare.one.plant]\nN = 1\n", ("compare.one.plant.N",)),
        (
            PLAIN + "[compare.one]\naxis = { file = 3 }\n",
            ("compare.one.axis.file", "name of a file"),
        ),
        (PLAIN.replace("duration = ", "length = "), ("run.length", "duration")),
        (
            PLAIN + '[disturbance]\nfile = "loop.csv"\nunit = "N"\n',
            ("disturbance.unit", "unknown key", "allowed keys: file"),
        ),
        (PLAIN.replace('"2 s"', '"1 ms"'), ("run.duration", "samples")),
        (PLAIN.replace("[run]", "[run]\nsettle = 3"), ("run.settle",)),
        (PLAIN.replace("[run]", "[run]\ncurrent_lag = '-1 ms'"), ("run.current_lag", ">= 0 s")),
        (PLAIN.replace("[run]", "[run]\ndelay = -1"), ("run.delay", "0 to")),
        (PLAIN.replace("[run]", "[run]\nsubsteps = inf"), ("run.substeps", "finite")),
        (PLAIN.replace("gain = 0.9", "gain = 'much'"), ("controller.feedforward.gain",)),
        (
            PLAIN.replace("gain = 0.9", "gian = 0.9"),
            ("controller.feedforward.gian", "Did you mean 'gain'"),
        ),
        (PLAIN.replace("[plant]", 'kind = "rotational"\n[plant]'), ("friction.F_C", "rotational")),
        (
            BY_AXIS.replace("schema = 1", 'schema = 1\nkind = "rotational"'),
            ("kind", "translational"),
        ),
        (BY_AXIS + "axis = 'nowhere.toml'\n", ("reference.axis", "nowhere.toml")),
        (BY_AXIS.replace("log.csv", "none.csv"), ("reference.file", "none.csv")),
        (BY_AXIS.replace("axis.toml", "log.csv"), ("axis.file", "log.csv", "TOML")),
        (
            BY_AXIS.replace('model = "coulomb"\nF_C = "3 N"', 'file = "model.toml"'),
            ("friction.file", "rotational"),
        ),
        (BY_MODEL.replace("F_C_neg", "F_C"), ("controller.feedforward.friction.F_C", "F_C_neg")),
        *((f"compare = {value}\n{PLAIN}", ("compare",)) for value in ('"x"', "-inf", "[1]")),
    ],
)
def test_errors_name_their_place(experiment, text, words):
    with pytest.raises(InputError) as caught:
        experiment(text, model=IDENTIFIED)
    assert [word for word in ("experiment.toml: ", *words) if word not in str(caught.value)] == []


SCREW = """
schema = 1
kind = "rotational"
plant = { model = "ball_screw", J = 1e-4, M = "20 kg", lead = "5 mm", k = "100 N/um" }
friction = { model = "coulomb", F_C = "20 mN*m" }
table_friction = { model = "coulomb", F_C = "40 N" }
controller = { model = "cascade", k_p = "60 1/s", k_v = "30 mN*m*s/rad" }
reference = { model = "sine", amplitude = "1 rad", frequency = "1 Hz" }
run = { duration = "1 s", sample_time = "1 ms" }
"""


def test_a_table_behind_a_screw_has_friction_in_its_own_units(tmp_path):
    (tmp_path / "screw.toml").write_text(SCREW + "[compare.table.sensor]\nside = 'load'\n")
    base, other = read_experiment(tmp_path / "screw.toml").variants
    assert base.table.kind == "translational"
    assert base.table.values["F_C"] == 40.0
    assert (base.sensor_at, other.sensor_at) == ("motor", "load")


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ("", "identify.own: needs a log or a simulated loop for the fit"),
        (
            'log = "log.csv"\nexcite = "loop"',
            "identify.own: needs a log or a simulated loop for the fit",
        ),
        ('log = "log.csv"\naxis = "axis.toml"', "identify.own: is not identified"),
        ('excite = "loop"', "identify.own: is not identified"),
        (
            'excite = "lop"',
            "identify.own.excite: is not a variant in this file; found 'lop', allowed loop. Did you mean 'loop'?",
        ),
        ('log = "gone.csv"', "identify.own.log: "),
    ],
)
def test_a_model_is_fitted_to_logs_or_to_an_excited_loop(experiment, entries, said):
    text = PLAIN.replace('friction = { model = "coulomb", F_C = "2.5 N" }', "")
    text = text.replace('model = "coulomb_viscous"\nF_C = "3 N"\nF_v = 4', 'identified = "own"')
    with pytest.raises(InputError, match=re.escape(said)):
        experiment(
            f'{text}[compare.loop.friction]\nmodel = "coulomb"\nF_C = 1\n[identify.own]\n{entries}\n'
        )


def planned(folder, digest="d1"):
    return Planned("friction", folder, digest, (), None, None, {})


def test_a_model_is_identified_anew_where_its_inputs_changed_and_never_taken_where_it_was_edited(
    tmp_path,
):
    plan = planned(tmp_path / "a")
    assert not plan.is_current, "nothing is there yet"
    with results_folder(plan.folder) as folder:
        folder.write("model.toml", "schema = 1\n")
        folder.write(*plan.note)
    assert plan.is_current
    assert not planned(plan.folder, "d2").is_current
    (plan.folder / "model.toml").write_text("schema = 2\n")
    with pytest.raises(InputError, match="was changed after its identification"):
        _ = plan.is_current


def test_a_loop_of_a_log_is_a_reference_with_its_own_sample_time(experiment, tmp_path):
    t = 2e-3 * np.arange(100)
    head = "time [s],reference [m],unexplained [N]"
    np.savetxt(
        tmp_path / "loop.csv",
        np.column_stack((t, np.cos(t), 3.0 * t)),
        delimiter=",",
        header=head,
        comments="",
        fmt="%.15g",
    )
    (base,) = experiment(
        BY_AXIS.replace("log.csv", "loop.csv") + '[disturbance]\nfile = "loop.csv"\n'
    ).variants
    assert base.reference.values["position"] == pytest.approx(np.cos(t))
    assert base.run.sample_time == pytest.approx(2e-3)
    assert base.disturbance == pytest.approx(3.0 * t)
