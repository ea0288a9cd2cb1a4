"""What bands are made of, through a model file and back."""

import re

import numpy as np
import pytest

from bristle import friction, plants
from bristle.core import InputError
from bristle.files import read_model
from bristle.files.model import NUMBERS, write_model
from bristle.identification.result import Bands

BANDS = Bands(
    {"F_C": np.array([7.9, 8.1, 8.0]), "M": np.array([20.0, 20.1, 19.9])},
    0.05,
    0.1,
    0.3,
    0.2,
    1.2,
    3e-6,
    4e-5,
)
MODEL = friction.find("coulomb_viscous")(F_C=8.0, F_v=40.0)


def written(path, bands=BANDS):
    write_model(path, plants.inertia(M=20.0), MODEL, bands=bands)
    return path


def test_bands_survive_a_round_trip(tmp_path):
    bands = Bands(**read_model(written(tmp_path / "model.toml")).info["bands"])
    numbers = (
        "scatter",
        "noise",
        "unexplained",
        "lasting",
        "inflation",
        "left_in_closed_loop",
        "left_in_open_loop",
        "count",
    )
    assert [getattr(bands, name) for name in numbers] == [0.05, 0.1, 0.3, 0.2, 1.2, 3e-6, 4e-5, 3]
    for name, values in BANDS.draws.items():
        np.testing.assert_allclose(bands.draws[name], values)


def test_lists_of_elements_survive_a_round_trip(tmp_path):
    model = friction.find("maxwell_slip")(F_C=10.0, k_i=[1e6, 2e6], nu_i=[0.4, 0.6])
    lists = {
        "k_i": np.array([[1e6, 2e6], [1.1e6, 1.9e6]]),
        "nu_i": np.full((2, 2), 0.5),
        "F_C": np.array([10.0, 9.0]),
    }
    write_model(
        tmp_path / "model.toml", plants.inertia(M=1.0), model, bands=Bands(lists, 0.0, 0.0, 0.0)
    )
    result = read_model(tmp_path / "model.toml").info["bands"]["draws"]
    np.testing.assert_allclose(result["k_i"], lists["k_i"])


def test_a_file_without_bands_gives_no_bands(tmp_path):
    assert read_model(written(tmp_path / "model.toml", None)).info["bands"] is None


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        *((f"{name} = ", f"{name} = -", f"bands.{name}") for name in NUMBERS),
        ("noise = 0.1", "noise = true", "bands.noise"),
        ("lasting = ", "# lasting = ", "bands.lasting: is missing"),
        ("left_in_open_loop = ", "# left_in_open_loop = ", "bands.left_in_open_loop: is missing"),
        ("inflation = 1.2", "inflation = nan", "bands.inflation"),
        ("F_C = [7.9, 8.1, 8.0]", 'F_C = "much"', "bands.draws.F_C"),
        ("F_C = [7.9, 8.1, 8.0]", "F_C = [7.9]", "bands.draws"),
        ("F_C = [7.9, 8.1, 8.0]", "F_X = [7.9, 8.1, 8.0]", "F_X"),
    ],
)
def test_invalid_bands_are_refused_with_their_place(tmp_path, old, new, named):
    path = written(tmp_path / "model.toml")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=re.escape(named)):
        read_model(path)
