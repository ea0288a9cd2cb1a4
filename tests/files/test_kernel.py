"""An operator for the kernel of a friction model in files: in a file of its own, in a table, with its offset."""

import re
import time
import tomllib

import numpy as np
import pytest

from bristle import friction, hysteresis
from bristle.core import InputError
from bristle.files.experiment import experiment_from, read_experiment
from bristle.files.model import friction_from, read_model, write_model
from bristle.files.operator import write_operator
from bristle.files.sources import Sources

EXPERIMENT = """
schema = 1
[plant]
M = "2 kg"
[friction]
model = "coulomb"
F_C = "3 N"
[controller]
model = "cascade"
k_p = 10
k_v = 20
[controller.feedforward]
friction = { FRICTION }
[reference]
model = "sine"
amplitude = "1 mm"
frequency = 1
[run]
duration = "2 s"
sample_time = "1 ms"
"""


@pytest.fixture
def table():
    return hysteresis.reversal_table(**hysteresis.reversal_table.example)


@pytest.fixture
def folder(tmp_path, table):
    (tmp_path / "found").mkdir()
    write_operator(tmp_path / "found" / "model.toml", table, 2.5)
    write_operator(tmp_path / "bare.toml", table)
    return tmp_path


def read(text, folder, kind="translational"):
    return friction_from(tomllib.loads(text), kind=kind, folder=folder, path="friction")


def fed_forward(folder, table):
    text = EXPERIMENT.replace("FRICTION", table)
    return (
        experiment_from(tomllib.loads(text), folder / "experiment.toml", Sources(folder))
        .variants[0]
        .feedforward
    )


@pytest.mark.parametrize(
    ("entries", "offset"),
    [
        ('kernel = "found/model.toml"', 2.5),
        ('kernel = { file = "found/model.toml" }', 2.5),
        ('offset = "0 N"\nkernel = "found/model.toml"', 0.0),  # what is written goes before
    ],
)
def test_a_file_names_the_kernel_and_its_offset_is_that_of_the_friction(
    folder, table, entries, offset
):
    content = read(f'model = "preisach_contact"\nsigma_2 = 2.0\n{entries}', folder)
    assert content == friction.find("preisach_contact")(kernel=table, sigma_2=2.0, offset=offset)


def test_the_kernel_may_be_a_table(folder):
    text = 'model = "preisach_lugre"\nF_C = "3 N"\nF_S = "4 N"\nv_S = "1 mm/s"\n[kernel]\n'
    content = read(
        text + 'model = "prandtl_ishlinskii"\nthresholds = ["1 um", "5 um"]\nweights = [4e6, 1e6]',
        folder,
    )
    stops = hysteresis.prandtl_ishlinskii(thresholds=[1e-6, 5e-6], weights=[4e6, 1e6])
    assert content == friction.find("preisach_lugre")(kernel=stops, F_C=3.0, F_S=4.0, v_S=1e-3)


def test_a_file_of_an_operator_is_friction_and_a_compensator(folder, table):
    contact = friction.find("preisach_contact")(kernel=table, offset=2.5)
    assert fed_forward(folder, 'file = "found/model.toml"').friction == contact
    text = EXPERIMENT.replace("friction = { FRICTION }", "").replace(
        'model = "coulomb"\nF_C = "3 N"', 'file = "OP"'
    )
    (folder / "run.toml").write_text(text.replace("OP", "found/model.toml"))
    experiment = read_experiment(folder / "run.toml")
    assert experiment.variants[0].friction == contact
    assert [origin.name for origin in experiment.origins["model"]] == ["model.toml"]


def test_the_file_of_a_kernel_is_an_origin(folder, table):
    text = EXPERIMENT.replace("FRICTION", 'model = "preisach_contact", kernel = "bare.toml"')
    (folder / "run.toml").write_text(text)
    experiment = read_experiment(folder / "run.toml")
    assert experiment.variants[0].feedforward.friction == friction.find("preisach_contact")(
        kernel=table
    )
    assert [origin.name for origin in experiment.origins["operator"]] == ["bare.toml"]


DIRECTED = {"F_C_pos": 3.0, "F_C_neg": 2.0, "F_S_pos": 4.0, "F_S_neg": 3.0, "v_S": 1e-3}


@pytest.mark.parametrize(
    ("name", "values"), [("preisach_contact", {}), ("preisach_lugre+asymmetry", DIRECTED)]
)
def test_a_model_over_an_operator_is_written_and_read_to_the_bit(tmp_path, table, name, values):
    model = friction.find(name)(kernel=table, offset=1.0 / 3.0, **values)
    write_model(tmp_path / "model.toml", None, model)
    assert read_model(tmp_path / "model.toml").friction == model
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.toml"]


def test_the_plane_of_a_hundred_branches_is_written_in_no_time(tmp_path):
    u = np.linspace(0.0, 1.0, 50)
    curves = [
        (turn + (1.0 - turn) * u, u * (1.0 - turn) / 3.0)
        for turn in np.linspace(-1.0, 0.9, 100).tolist()
    ]
    model = friction.find("preisach_contact")(kernel=hysteresis.table_of_curves(curves))
    assert model.kernel_E.size > 20_000
    begin = time.process_time()
    write_model(tmp_path / "model.toml", None, model)
    assert time.process_time() - begin < 2.0
    assert read_model(tmp_path / "model.toml").friction == model


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('model = "preisach_contact"\nkernel = "no.toml"', "friction.kernel"),
        (
            'model = "preisach_contact"\nkernel = { file = "bare.toml", s = 1 }',
            "friction.kernel.s: unknown key",
        ),
        (
            'model = "preisach_contact"\nkernel = { file = 3 }',
            "friction.kernel.file: must be the name of a file; found 3",
        ),
        (
            'model = "preisach_contact"\nkernel = { file = "bare.toml", model = "play" }',
            "friction.kernel.model: unknown key",
        ),
        (
            'model = "preisach_contact"\nkernel = { model = "play", r = 1 }',
            "friction.kernel: gives no force",
        ),
        (
            'model = "preisach_contact"\nkernel = { thresholds = [1] }',
            "friction.kernel: names no model",
        ),
        (
            'model = "preisach_contact"\nkernel = "magic"\ns = 1\nf_p = 1',
            "friction.kernel: is not a valid choice",
        ),
        (
            'model = "preisach_contact"\nkernel = "bare.toml"\ns = 1',
            "friction.s: preisach_contact+reversal",
        ),
        ('model = "lugre"\nkernel = "bare.toml"', "friction.kernel: unknown key"),
    ],
)
def test_invalid_kernels_are_refused_with_their_key(folder, text, said):
    with pytest.raises(InputError, match=re.escape(said)):
        read(text, folder)


@pytest.mark.parametrize("kind", ["magnetic", "rotational"])
@pytest.mark.parametrize(
    "entry", ['file = "other.toml"', 'model = "preisach_contact", kernel = "other.toml"']
)
def test_an_operator_of_another_kind_is_refused(folder, entry, kind):
    write_operator(
        folder / "other.toml",
        hysteresis.prandtl_ishlinskii(kind=kind, thresholds=[0.1], weights=[1.0]),
    )
    with pytest.raises(InputError, match=kind):
        fed_forward(folder, entry)


def test_numbers_of_a_kernel_are_bounded_as_elsewhere():
    values = {f"kernel_{name}": value for name, value in hysteresis.reversal_table.example.items()}
    with pytest.raises(InputError, match="kernel_capacity"):
        friction.find("preisach_contact+reversal_table")(**values, kernel_capacity=2)
