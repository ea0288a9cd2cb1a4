"""Draws of a fit as tables: whole rows of what the bootstrap found, and the same in the words of MuJoCo."""

import csv
import json
import tracemalloc

import numpy as np
import pyarrow.parquet
import pytest
from tests.identification.known_logs import sliding_log

from bristle import identify
from bristle.cli.main import main
from bristle.core import InputError
from bristle.exports.described import Source
from bristle.exports.draws import MOST, draws_files
from bristle.exports.mjcf import mjcf_text
from bristle.friction import coulomb_viscous, lugre, with_slots
from bristle.plants import inertia

GENERATOR = np.random.default_rng(4)
LEVEL = GENERATOR.normal(8.0, 0.5, 50)
DRAWN = {"M": GENERATOR.normal(3.0, 0.1, 50), "F_C": LEVEL, "F_v": 20.0 - 2.0 * LEVEL, "offset": LEVEL - 8.0}
MODEL, PLANT = with_slots(coulomb_viscous, [])(F_C=8.0, F_v=4.0), inertia(M=3.0)


def rows(text):
    header, *lines = csv.reader(text.splitlines())
    return header, [[float(cell) for cell in line] for line in lines]


def test_rows_are_those_of_the_fit_with_their_units():
    files, notes = draws_files(MODEL, PLANT, DRAWN, 20, "axis_x")
    header, result = rows(files["axis_x_draws.csv"])
    assert header == ["M [kg]", "F_C [N]", "F_v [N*s/m]", "offset [N]"]
    assert np.array(result).tobytes() == np.column_stack(list(DRAWN.values()))[:20].tobytes()
    assert notes == ("20 of the 50 draws of the fit",)


def test_more_than_there_are_are_drawn_again_as_whole_rows_and_it_is_told():
    files, notes = draws_files(MODEL, PLANT, DRAWN, 400, "axis_x")
    _, result = rows(files["axis_x_draws.csv"])
    stored = {tuple(row) for row in np.column_stack(list(DRAWN.values())).tolist()}
    assert len(result) == 400
    assert {tuple(row) for row in result} <= stored
    assert len({tuple(row) for row in result}) > 40
    assert notes[0].startswith("400 draws, with replacement, of the 50 of the fit")


def test_a_row_for_mujoco_is_the_scene_of_that_draw():
    files, _ = draws_files(MODEL, PLANT, DRAWN, 5, "axis_x")
    table = list(csv.DictReader(files["axis_x_mjcf.csv"].splitlines()))
    values = {name: float(DRAWN[name][3]) for name in ("F_C", "F_v", "offset")}
    scene = mjcf_text(MODEL.with_values(**values), "axis_x", Source(), float(DRAWN["M"][3]))
    assert f'frictionloss="{table[3]["joint.frictionloss"]}" damping="{table[3]["joint.damping"]}"' in scene
    assert f'mass="{table[3]["inertial.mass"]}"' in scene
    assert f'ctrl="{table[3]["key.ctrl"]}"' in scene


def test_a_draw_that_is_no_model_is_left_out_of_the_scenes_alone():
    model = lugre(F_C=8.0, F_S=9.0, v_S=1e-3, sigma_0=1e5)
    drawn = {"F_C": np.array([8.0, 9.5, 7.5]), "F_S": np.array([9.0, 9.0, 8.5])}
    files, notes = draws_files(model, None, drawn, 3, "axis_x")
    assert len(rows(files["axis_x_draws.csv"])[1]) == 3
    assert [line["draw"] for line in csv.DictReader(files["axis_x_mjcf.csv"].splitlines())] == ["0", "2"]
    assert notes[1].startswith("1 of them break a condition of the model")


def test_what_mujoco_has_not_has_no_scenes():
    sided = with_slots(coulomb_viscous, ["asymmetry"])(F_C_pos=8.0, F_C_neg=7.0, F_v_pos=4.0, F_v_neg=4.0)
    files, _ = draws_files(sided, PLANT, {"F_C_pos": LEVEL}, 3, "axis_x")
    assert "axis_x_mjcf.csv" not in files


def test_without_draws_there_is_nothing_to_export():
    with pytest.raises(InputError, match="holds no draws: it was identified without intervals"):
        draws_files(MODEL, PLANT, {}, 10, "axis_x")


@pytest.mark.parametrize("count", [0, -1, MOST + 1, 10**9])
def test_more_rows_than_a_table_holds_are_refused_before_anything_is_made(count):
    with pytest.raises(InputError, match=rf"found {count}, allowed 1 to 1000000\b"):
        draws_files(MODEL, PLANT, DRAWN, count, "axis_x")


def test_a_long_table_is_made_of_the_rows_of_the_fit_in_the_memory_of_its_text():
    count = 40_000
    draws_files(MODEL, PLANT, DRAWN, 1, "axis_x")  # imports are none of the memory of a table
    tracemalloc.start()
    files, _ = draws_files(MODEL, PLANT, DRAWN, count, "axis_x")
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    texts = [files[f"axis_x_{name}.csv"] for name in ("draws", "mjcf")]
    assert [text.count("\n") for text in texts] == [count + 1] * 2
    assert most < 3.5 * sum(map(len, texts))
    _, result = rows(texts[0])
    scenes = list(csv.DictReader(texts[1].splitlines()))
    for row in (0, 17, count - 1):
        assert [float(scenes[row][name]) for name in ("joint.frictionloss", "joint.damping")] == result[row][1:3]
        assert float(scenes[row]["inertial.mass"]) == result[row][0]
        assert scenes[row]["draw"] == str(row)


def test_results_leave_with_their_draws(tmp_path, capsys):
    identified = identify(sliding_log(), "coulomb_viscous", draws=20)
    identified.save(tmp_path / "results")
    results, out = str(tmp_path / "results"), tmp_path / "draws"
    assert main(["export", results, "--to", "draws", "--draws", "10", "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"] == ["10 of the 20 draws of the fit"]
    table = pyarrow.parquet.read_table(out / "axis_x_draws.parquet")
    for name in table.column_names:
        assert table[name].to_pylist() == identified.draws[name][:10].tolist()
    assert table.schema.field("F_C").metadata == {b"unit": b"N"}
    assert main(["export", results, "--to", "draws", "--draws", "1000000000", "--out", str(tmp_path / "many")]) == 2
    assert "1 to 1000000" in capsys.readouterr().err
    assert not (tmp_path / "many").exists()
    assert main(["export", results, "--to", "c", "--draws", "10", "--out", str(tmp_path / "c")]) == 2
    assert "c: holds one model, not draws of it" in capsys.readouterr().err
