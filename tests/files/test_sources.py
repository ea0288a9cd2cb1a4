"""The files that an experiment names: each read once, for what it is, and refused with the key that names it."""

import numpy as np
import pytest

from bristle.core.contracts import Sensor
from bristle.core.errors import InputError
from bristle.files.sources import Sources

AXIS = 'schema = 1\nkind = "translational"\n[columns]\ntime = "t"\nposition = "q"\nreference = "r"\neffort = "u"\n'
MODEL = 'schema = 1\nkind = "translational"\n[plant]\nmodel = "inertia"\nM = 2.0\n[friction]\nmodel = "coulomb"\nF_C = 3.0\n'
T = 1e-3 * np.arange(300)


@pytest.fixture
def sources(tmp_path):
    (tmp_path / "axis.toml").write_text(AXIS)
    (tmp_path / "model.toml").write_text(MODEL)
    columns = np.column_stack((T, np.sin(9.0 * T), np.sin(9.0 * T) + 0.1, np.cos(9.0 * T)))
    np.savetxt(
        tmp_path / "log.csv", columns, delimiter=",", header="t,q,r,u", comments="", fmt="%.15g"
    )
    np.savetxt(
        tmp_path / "motion.csv",
        columns[:, :3],
        delimiter=",",
        header="t,q,r",
        comments="",
        fmt="%.15g",
    )
    gap = np.arange(300) != 150
    columns[151:, 0] += 1.0
    np.savetxt(
        tmp_path / "gap.csv",
        columns[gap],
        delimiter=",",
        header="t,q,r,u",
        comments="",
        fmt="%.15g",
    )
    return Sources(tmp_path)


def test_each_file_is_read_once_and_kept_by_its_role(sources):
    axis = sources.axis("axis.toml", "axis.file")
    assert sources.axis("axis.toml", "axis.file") is axis
    assert sources.model("model.toml", "friction.file") is sources.model(
        "model.toml", "controller.file"
    )
    log = sources.log("log.csv", axis, "reference.file")
    assert sources.log("log.csv", axis, "effort.file") is log
    assert {
        role: [origin.name for origin in origins]
        for role, origins in sources.origins.items()
        if origins
    } == {"axis": ["axis.toml"], "model": ["model.toml"], "log": ["log.csv"]}


def test_a_plant_and_an_operator_are_looked_for_among_their_own_kind(sources):
    assert sources.listed(
        "plant", {"model": "inertia", "M": 2.0}, "translational", "plant"
    ).values == {"M": 2.0}
    assert sources.listed(
        "hysteresis", {"model": "play", "r": "1 um"}, "translational", "hysteresis"
    ).values == {"r": 1e-6}


@pytest.mark.parametrize(
    ("table", "plant", "level"),
    [
        ({"model": "coulomb", "F_C": "5 N"}, None, 5.0),
        ({"file": "model.toml"}, {"M": 2.0}, 3.0),
        ({"file": "model.toml", "F_C": "4 N"}, {"M": 2.0}, 4.0),
    ],
)
def test_friction_is_that_of_a_table_or_of_a_model_file_with_its_plant(
    sources, table, plant, level
):
    found, model = sources.friction(table, "translational", "friction")
    assert (found and found.values, model.values["F_C"]) == (plant, level)


@pytest.mark.parametrize(("file", "shift"), [("log.csv", 0.1), ("motion.csv", 0.1)])
def test_a_reference_is_from_a_log_or_a_planned_motion(sources, file, shift):
    axis = sources.axis("axis.toml", "axis.file")
    values = sources.recorded({"model": "recorded", "file": file}, axis, "reference").values
    assert values["position"] == pytest.approx(np.sin(9.0 * T) + shift)
    assert values["sample_time"] == pytest.approx(1e-3)
    of_own_axis = sources.recorded(
        {"model": "recorded", "file": file, "axis": "axis.toml"}, None, "reference"
    ).values
    assert of_own_axis["position"] == pytest.approx(values["position"])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        *(
            (
                lambda sources, file=file: sources.axis(file, "axis.file"),
                r"axis\.file: must be the name of a file",
            )
            for file in (3, "", None)
        ),
        (
            lambda sources: sources.recorded(
                {"model": "recorded", "file": "gap.csv", "axis": "axis.toml"}, None, "reference"
            ),
            r"reference\.file: has gaps, which split it into 2 parts",
        ),
        (
            lambda sources: sources.friction({"file": "model.toml"}, "rotational", "friction"),
            r"friction\.file: is the model of a translational axis, but this axis is rotational",
        ),
        (
            lambda sources: sources.listed(
                "plant", {"model": "play", "r": 1.0}, "translational", "plant"
            ),
            r"plant\.model",
        ),
    ],
)
def test_files_of_another_kind_are_refused_with_their_key(sources, call, words):
    with pytest.raises(InputError, match=words):
        call(sources)


def test_a_table_without_a_file_names_no_code_and_no_model(sources):
    assert sources.own({"model": "encoder"}, Sensor, "sensor") is None
    tables = ({"model": "coulomb"}, {"file": "own.py"}, {"file": "model.toml"})
    assert [sources.fitted_to(table, "friction") for table in tables] == ["", "", ""]
