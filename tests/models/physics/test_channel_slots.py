"""Slots of bristle over a channel of a log: one file and one name each, and friction of seals under pressure."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.files.own_slot import SLOT

import bristle as br
from bristle.contract import check_model
from bristle.contract.contract import OF_SLOT
from bristle.core import InputError
from bristle.core.errors import InputWarning
from bristle.core.slot import refuse_unfit
from bristle.engine import force_along, interpreted
from bristle.files import load_slot_file, read_model, write_model
from bristle.models.friction import (
    CHANNEL_SLOTS,
    MODELS,
    channel_slots_of,
    channels,
    coulomb_viscous,
    find,
    is_static,
    unvaried,
    with_slots,
)
from bristle.models.friction.channels import pressure as of_seals
from bristle.models.friction.next_model import model_with

ROOT = Path(__file__).parents[3]
V, PRESSURE = np.array([0.1, -0.2, 0.3, -0.4]), np.array([0.0, 2e6, 5e6, 1e7])


def test_every_file_has_its_name_in_the_list():
    folder = Path(channels.__file__).parent
    files = {
        file.stem
        for file in folder.glob("*.py")
        if re.search(r"^SLOT = ", file.read_text(), re.MULTILINE)
    }
    assert files == set(CHANNEL_SLOTS)
    for name, slot in CHANNEL_SLOTS.items():
        assert slot.name == name
        refuse_unfit(slot)
        assert re.search(r"doi:10\.\d{4}", slot.reference)
        assert not set(slot.variables) & {
            variable for model in MODELS.values() for variable in model.variables
        }


@pytest.mark.parametrize("name", CHANNEL_SLOTS)
def test_every_slot_meets_the_contract_and_is_found_by_name(name):
    checks = check_model(CHANNEL_SLOTS[name])
    assert [check for check in checks if not check.passed] == []
    assert len(checks) == len(OF_SLOT)
    model = find(f"coulomb_viscous+{name}")
    assert channel_slots_of(model) == (CHANNEL_SLOTS[name],)
    assert channel_slots_of(model)[0] is CHANNEL_SLOTS[name]


# --- seals under pressure ----------------------------------------------------------------------------------------


def test_the_level_at_the_stated_pressure_is_that_of_the_model():
    assert [
        of_seals.factor(pressure, of_seals.Parameters(1e-7, 2e6)) for pressure in (2e6, 3e6, 0.0)
    ] == pytest.approx([1.0, 1.1, 0.8])
    slot = of_seals.SLOT
    assert (slot.neutral, slot.identified, slot.of, slot.channel.usual) == (
        (0.0, 0.0),
        ("k_P",),
        "level",
        0.0,
    )
    # Of the order of hydraulics: megapascals, and a tenth for each.
    assert [variable.nominal for variable in (*slot.variables.values(), slot.channel.variable)] == [
        1e-7,
        1e6,
        1e7,
    ]
    assert dict(slot.example) == {"k_P": 1e-7}
    assert slot.channel.variable.min == 0.0


PRESSED = find("coulomb_viscous+pressure")(
    F_C="80 N", F_v="300 N*s/m", k_P="0.02 1/bar", P_0="10 bar"
)


@pytest.mark.parametrize(
    ("model", "around", "level"),
    [
        (PRESSED, {"pressure": PRESSURE}, 80.0 * (1.0 + 0.02 * (PRESSURE / 1e5 - 10.0))),
        (PRESSED, {}, 64.0),
        (unvaried(PRESSED), {"pressure": PRESSURE}, 80.0),
    ],
)
def test_pressure_raises_dry_friction_only(model, around, level):
    with interpreted():
        assert force_along(model, V, 1e-3, **around) == pytest.approx(
            level * np.sign(V) + 300.0 * V
        )


def test_a_rotational_axis_may_have_a_pressure():
    model = find("coulomb+pressure")(
        kind="rotational", F_C="2 N*m", k_P="0.01 1/bar", P_0="-10 bar"
    )
    assert model.values["k_P"] == pytest.approx(1e-7)
    assert model.component.surroundings[0].variable.unit("rotational") == "N/m^2"
    with interpreted():
        assert force_along(model, V, 1e-3, pressure=9e6) == pytest.approx(4.0 * np.sign(V))


def test_a_channel_slot_has_one_place_in_a_name_and_combines_with_all_slots():
    model = with_slots(coulomb_viscous, ["pressure", "asymmetry", "load"])
    assert model is find("coulomb_viscous+load+pressure+asymmetry")
    assert model.name == "coulomb_viscous+load+pressure+asymmetry"
    assert [surrounding.name for surrounding in model.surroundings] == ["load", "pressure"]


def test_a_model_file_names_the_slot_without_a_code_file(tmp_path):
    model = find("lugre+pressure")(F_C=20.0, F_S=25.0, v_S=1e-3, sigma_0=1e6, k_P=2e-7)
    write_model(tmp_path / "model.toml", None, model)
    assert 'model = "lugre+pressure"' in (tmp_path / "model.toml").read_text()
    assert [file.name for file in tmp_path.iterdir()] == ["model.toml"]
    assert read_model(tmp_path / "model.toml").friction == model
    both = with_slots(coulomb_viscous, ["pressure", CUSTOM])(F_C=20.0, F_v=1.0, k_P=2e-7, k_H=0.3)
    write_model(tmp_path / "both.toml", None, both)
    assert 'model = "coulomb_viscous+pressure+humidity.py"' in (tmp_path / "both.toml").read_text()
    with pytest.warns(InputWarning, match=r"humidity\.py .* is run"):
        assert read_model(tmp_path / "both.toml", allow_code=True).friction == both


CUSTOM = load_slot_file(ROOT / "examples" / "humidity.py")
OILED = load_slot_file(SLOT.replace('"oiled"', '"smeared"').encode())  # by another equation
FILM = {"F_C": 8.0, "F_v": 30.0}


@pytest.mark.parametrize(
    ("need", "model", "name"),
    [
        ("pressure", coulomb_viscous(**FILM), "coulomb_viscous+pressure"),
        ("pressure", find("coulomb_viscous+pressure")(**FILM), ""),
        (
            "direction",
            find("coulomb_viscous+pressure")(**FILM),
            "coulomb_viscous+pressure+asymmetry",
        ),
        (
            "direction",
            with_slots(coulomb_viscous, [CUSTOM])(**FILM),
            "coulomb_viscous+humidity+asymmetry",
        ),
        ("pressure", with_slots(coulomb_viscous, [OILED])(**FILM), ""),
        ("pressure", MODELS["maxwell_slip"](**MODELS["maxwell_slip"].example), ""),
    ],
)
def test_the_next_model_has_each_slot_once_and_keeps_user_defined_slots(need, model, name):
    assert model_with(need, model) == name


def test_a_user_defined_slot_may_not_have_the_name_of_a_built_in_slot(tmp_path):
    text = (ROOT / "examples" / "humidity.py").read_text(encoding="utf-8")
    (tmp_path / "mine.py").write_text(
        text.replace('name="humidity"', 'name="pressure"'), encoding="utf-8"
    )
    with pytest.raises(InputError, match=r"an invalid name for its slot; found 'pressure'"):
        load_slot_file(tmp_path / "mine.py")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("lugre+pressure+pressure", "a slot twice"),
        ("lugre+presure", r"no such slot.*\+pressure.*or a file of yours"),
    ],
)
def test_an_unknown_slot_or_one_given_twice_is_refused(name, words):
    with pytest.raises(InputError, match=words):
        find(name)


# --- another one -------------------------------------------------------------------------------------------------

GROWN = '''
import importlib.util, json, sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

LIST, FOLDER = "bristle.models.friction.channels", sys.argv[1]

class Grown(SourceFileLoader):
    """The list with one more name; the file of it lies in another folder."""
    def get_code(self, name):
        text = self.get_source(name)
        assert text.count('FILES = ("pressure",') == 1
        return compile(text.replace('FILES = ("pressure",', 'FILES = ("pressure", "humidity",'), self.path, "exec")

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name != LIST:
            return None
        file = str(Path(path[0], "channels", "__init__.py"))
        spec = importlib.util.spec_from_file_location(name, file, loader=Grown(name, file))
        spec.submodule_search_locations.append(FOLDER)
        return spec

sys.meta_path.insert(0, Finder())
import contextlib, io
import bristle as br
from bristle.cli.main import main
from bristle.models.friction import MODELS, find
from bristle.models.friction.next_model import model_with

def printed(*arguments):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(list(arguments)) == 0, arguments
    return out.getvalue()

spec = importlib.util.spec_from_file_location("generate", sys.argv[2])
generate = importlib.util.module_from_spec(spec)
spec.loader.exec_module(generate)
model = find("coulomb_viscous+humidity+pressure")(F_C=8.0, F_v=30.0, k_H=0.4)
br.write_model("model.toml", None, model)
br.export(model, "c", "out")
print(json.dumps({
    "name": model.name,
    "same": br.read_model("model.toml").friction == model,
    "files": sorted(file.name for file in Path().iterdir()),
    "list": printed("models"), "one": printed("models", "humidity"),
    "json": json.loads(printed("models", "lugre+humidity", "--json")),
    "reference": generate.PAGES["models.md"](), "symbols": generate.PAGES["symbols.md"](),
    "next": model_with("humidity", MODELS["coulomb"](F_C=1.0)),
    "header": Path("out", "axis_x.h").read_text(),
}))
'''


@pytest.mark.slow
def test_a_new_channel_slot_needs_one_file_and_one_name(tmp_path):
    """The slot of the pages, put into the folder as it stands, with its name in the list: all else follows."""
    folder, work = tmp_path / "folder", tmp_path / "work"
    for made in (folder, work):
        made.mkdir()
    (folder / "humidity.py").write_bytes((ROOT / "examples" / "humidity.py").read_bytes())
    line = [sys.executable, "-c", GROWN, str(folder), str(ROOT / "docs" / "generate.py")]
    ended = subprocess.run(line, cwd=work, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    data = json.loads(ended.stdout)
    assert (data["name"], data["same"]) == ("coulomb_viscous+pressure+humidity", True)
    assert data["files"] == ["model.toml", "out"]
    assert re.search(r"\+humidity\s+│?\s*k_H, h_0", data["list"])
    assert "Needs channel humidity of the log: relative humidity" in data["one"]
    assert data["json"]["models"][0]["channels"] == ["humidity"]
    assert "### humidity" in data["reference"]
    assert "[`+humidity`](#humidity)" in data["reference"]
    assert "[humidity](models.md#humidity)" in data["symbols"]
    assert data["next"] == "coulomb+humidity"
    assert "double humidity" in data["header"]


def test_a_static_model_with_a_channel_slot_is_static():
    assert is_static(find("coulomb+pressure")(F_C=1.0))
    assert br.friction.with_presliding(find("coulomb+pressure")(F_C=1.0), 1e-6).values["k_P"] == 0.0
