"""Model files: numbers to the bit, provenance, models of a user's own."""

import datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from bristle import friction, plants
from bristle.contract import example_of
from bristle.core import InputError
from bristle.core.errors import InputWarning
from bristle.core.packing import pack
from bristle.files.model import read_model, write_model
from bristle.files.user_model import load_code
from bristle.identification import Estimate
from bristle.models.friction import MODELS, find

positive = st.floats(min_value=1e-11, max_value=1e15)


@given(
    M=positive,
    F_C=positive,
    F_v=st.floats(min_value=0.0, max_value=1e100),
    offset=st.floats(-1e9, 1e9),
)
def test_numbers_survive_a_round_trip_exactly(tmp_path_factory, M, F_C, F_v, offset):
    path = tmp_path_factory.getbasetemp() / "model.toml"
    plant = plants.inertia(M=M)
    model = find("coulomb_viscous")(F_C=F_C, F_v=F_v, offset=offset)
    write_model(path, plant, model)
    result = read_model(path)
    assert (result.plant, result.friction.values) == (plant, model.values)


@pytest.mark.parametrize("kind", ["translational", "rotational"])
@pytest.mark.parametrize("slot", ["", "+asymmetry"])
@pytest.mark.parametrize("name", MODELS)
def test_every_model_of_both_kinds_survives_a_round_trip(tmp_path, name, slot, kind):
    values = example_of(find(name + slot)).values
    model = find(name + slot)(kind=kind, **values)
    write_model(tmp_path / "model.toml", None, model)
    result = read_model(tmp_path / "model.toml")
    assert (result.plant, result.friction.name, result.friction.kind) == (None, name + slot, kind)
    np.testing.assert_equal(result.friction.values, values)


def test_units_meanings_and_uncertainty_are_written_for_people(tmp_path):
    model = find("coulomb")(F_C=8.0)
    estimates = [
        Estimate("M", "kg", "mass", 20.0, 0.25, robust_std=0.75),
        Estimate("F_C", "N", "level", 8.0, None, "at_edge"),
        Estimate("offset", "N", "offset", 0.0, None, "held"),
    ]
    path = tmp_path / "model.toml"
    write_model(
        path,
        plants.inertia(M=20.0),
        model,
        estimates=estimates,
        provenance={"command": 'a "b" \\ c'},
        notes={"F_C": 'the "edge"\nof what is sought', "M": ""},
    )
    assert "M = 20.0 # kg: moving mass or inertia" in path.read_text()
    info = read_model(path).info
    assert info["provenance"] == {"command": 'a "b" \\ c'}
    assert info["uncertainty"] == {
        "M": {"std": 0.25, "robust_std": 0.75, "status": "identified"},
        "F_C": {"status": "at_edge", "note": 'the "edge"\nof what is sought'},
        "offset": {"status": "held"},
    }


def test_the_treatment_survives_a_round_trip(tmp_path):
    path = tmp_path / "model.toml"
    treatment = {
        "cutoff": 37.5,
        "decimation": 4.0,
        "rows": 900.0,
        "velocity_max": 0.3,
        "lag": 2.8e-4,
    }
    write_model(path, None, find("coulomb")(F_C=8.0), treatment=treatment)
    assert "cutoff = 37.5 # Hz: " in path.read_text()
    assert read_model(path).info["treatment"] == {
        "cutoff": 37.5,
        "decimation": 4,
        "velocity_max": 0.3,
        "lag": 2.8e-4,
    }
    write_model(path, None, find("coulomb")(F_C=8.0))
    assert read_model(path).info["treatment"] == {}


def test_a_users_own_model_travels_with_its_file(tmp_path, own_model):
    component = load_code(own_model)
    (tmp_path / "there").mkdir()
    path = tmp_path / "there" / "model.toml"
    write_model(
        path,
        None,
        friction.with_slots(component, ["asymmetry"])(F_0_pos=3.0, F_0_neg=4.0, lambda_=0.5),
    )
    assert "lambda = 0.5" in path.read_text()
    own_model.unlink()
    with pytest.warns(InputWarning, match=r"own\.py \(SHA-256 [0-9a-f]{64}\) is run"):
        result = read_model(path, allow_code=True).friction
    assert result.name == "own+asymmetry"
    assert result.values == {"F_0_pos": 3.0, "F_0_neg": 4.0, "lambda_": 0.5, "offset": 0.0}


def test_a_user_model_is_not_confused_with_a_model_of_the_same_name(tmp_path, own_model):
    own_model.write_text(own_model.read_text().replace('name="own"', 'name="coulomb"'))
    model = friction.with_slots(load_code(own_model), [])(F_0=3.0)
    path = tmp_path / "model.toml"
    write_model(path, None, model)
    with pytest.warns(InputWarning):
        assert read_model(path, allow_code=True).friction.values["F_0"] == 3.0


def test_a_users_own_model_has_no_slots_but_those_that_there_are(tmp_path, own_model):
    path = tmp_path / "model.toml"
    path.write_text("schema = 1\n[friction]\nfile = 'own.py'\nslots = ['cold']\nF_0 = 1\n")
    with (
        pytest.raises(InputError, match=r"friction\.slots.*\+asymmetry"),
        pytest.warns(InputWarning),
    ):
        read_model(path, allow_code=True)


HEAD = 'schema = 1\n[friction]\nmodel = "coulomb"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("schema", "schema = 1")),
        ("schema = 2\n", ("schema", "newer")),
        ("schema = true\n", ("schema",)),
        ("schema = 1\n", ("friction", "is missing")),
        ("schema = 1\nfriction = 3\n", ("friction", "[friction]")),
        (HEAD, ("friction", "F_C")),
        (HEAD + "F_C = 3\nF_S = 4\n", ("friction.F_S", "offset")),
        (HEAD + 'F_C = "3 kg"\n', ("friction.F_C", "N")),
        (HEAD + "F_C = 3\nfile = 'x.py'\n", ("both",)),
        (HEAD + "F_C = 3\n[plant]\nM = 1\n", ("plant", "inertia")),
        (HEAD + "F_C = 3\n[uncertainty]\nF_D = 1\n", ("uncertainty.F_D", "Did you mean 'F_C'")),
        (HEAD + "F_C = 3\n[provenance]\n[[plant]]\n", ("plant", "table")),
        ("schema = 1\nkind = 'round'\n" + HEAD[11:] + "F_C = 3\n", ("kind", "rotational")),
        ("schema = 1\n[friction]\nfile = 'model.toml'\n", ("friction.file", ".py")),
        ("schema = 1\n[friction]\nfile = 'own.py'\nslots = 'asymmetry'\n", ("friction.slots",)),
        ("schema = 1\n[friction]\nfile = 'other.py'\n", ("other.py",)),
        ("schema = 1\n[friction]\nmodel = ['coulomb']\n", ("friction.model",)),
        (HEAD + 'F_C = 3\n[treatment]\ncutoff = "3 m"\n', ("treatment.cutoff",)),
        (HEAD + "F_C = 3\n[treatment]\ncutoff = -3.0\n", ("treatment.cutoff",)),
        (HEAD + "F_C = 3\n[treatment]\ndecimation = 2.5\n", ("treatment.decimation",)),
        (HEAD + "F_C = 3\n[treatment]\ndecimation = 0\n", ("treatment.decimation",)),
        (HEAD + "F_C = 3\n[treatment]\ncut_off = 3.0\n", ("treatment.cut_off",)),
    ],
)
def test_errors_are_named(tmp_path, own_model, text, words):
    path = tmp_path / "model.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert str(caught.value).startswith(str(path))
    assert [word for word in words if word not in str(caught.value)] == []


@pytest.mark.parametrize("name", ["preisach_lugre", "leuven+asymmetry", "gms", "elastoplastic"])
def test_models_with_memory_survive_a_round_trip_exactly(name, tmp_path):
    friction_model = example_of(find(name))
    path = tmp_path / "model.toml"
    write_model(path, None, friction_model)
    result = read_model(path).friction
    assert (result.name, pack(result.parameters).tobytes()) == (
        name,
        pack(friction_model.parameters).tobytes(),
    )


def test_a_choice_is_written_by_name_and_an_invalid_choice_is_refused(tmp_path):
    path = tmp_path / "model.toml"
    write_model(path, None, example_of(find("preisach_lugre")))
    text = path.read_text()
    assert 'kernel = "dahl_masing"' in text
    path.write_text(text.replace("dahl_masing", "dahl_massing"))
    with pytest.raises(
        InputError, match=r"friction.kernel.*dahl_massing.*allowed dahl_masing.*Did you mean"
    ):
        read_model(path)


@pytest.mark.parametrize(
    ("bad", "plant", "model"),
    [("plant", 5, friction.coulomb(F_C=1.0)), ("friction", None, friction.coulomb)],
)
def test_invalid_models_are_refused_before_writing(bad, plant, model, tmp_path):
    with pytest.raises(InputError, match=rf"^{bad}: must be a {bad} model with parameters"):
        write_model(tmp_path / "model.toml", plant, model)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("value", [None, datetime.date(2026, 1, 1), Path("log.csv"), ["a", None]])
def test_values_beyond_toml_are_refused_and_the_file_is_unchanged(value, tmp_path):
    path, plant, model = tmp_path / "model.toml", plants.inertia(M=1.0), friction.coulomb(F_C=1.0)
    write_model(path, plant, model)
    before = path.read_bytes()
    with pytest.raises(
        InputError, match=r"^provenance\.made: cannot be written; found .*, allowed text, a number"
    ):
        write_model(path, plant, model, provenance={"made": value})
    assert path.read_bytes() == before
