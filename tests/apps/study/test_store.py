"""The folder of a study: blocks that are whole, the same study gone on with, another one refused, the runs as a data set."""

import errno
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pyarrow.parquet import read_table, write_table
from tests.apps.study.conftest import STUDY, content

import bristle as br
from bristle.apps.study import read_study_file, run_study
from bristle.apps.study.block import Simulator
from bristle.apps.study.store import opened, refuse_another, runs_in, study_in
from bristle.files.growing import growing_folder
from bristle.files.owned import NOTE, Folder


@pytest.fixture
def done(bench):
    """A study, and the folder that holds all of its runs."""
    study, out = bench.study(), bench.folder / "out"
    run_study(study, out, workers=1)
    return study, out


def test_an_interrupted_study_continues(bench, monkeypatch):
    study = bench.study()
    ran = run_study(study, bench.folder / "whole", workers=1)
    assert (len(study.blocks), ran.before, ran.is_whole) == (3, 0, True)
    run_study(study, bench.folder / "part", workers=1)
    (bench.folder / "part" / "runs" / "0000000004.parquet").unlink()
    simulated = []
    columns = Simulator.columns
    monkeypatch.setattr(
        Simulator, "columns", lambda self, block: simulated.append(block) or columns(self, block)
    )
    ran = run_study(study, bench.folder / "part", workers=1)
    assert ran.before == 2
    assert [block.first for block in simulated] == [4]
    assert content(bench.folder / "part") == content(bench.folder / "whole")


def test_files_hold_the_runs_with_their_units(bench):
    study = bench.study()
    run_study(study, bench.folder / "out", workers=1)
    table = read_table(bench.folder / "out" / "runs" / "0000000004.parquet")
    assert table.column_names == [
        "run",
        "seed",
        "status",
        "reason",
        "friction.F_C",
        "plant.M",
        "motion.peak_to_peak",
        "effort.rms",
    ]
    assert table["run"].to_pylist() == [4, 5, 6, 7]
    assert table["reason"].to_pylist() == [None] * 4
    assert {field.name: field.metadata[b"unit"] for field in table.schema if field.metadata} == {
        "friction.F_C": b"N",
        "plant.M": b"kg",
        "motion.peak_to_peak": b"m",
        "effort.rms": b"N",
    }


@pytest.mark.parametrize(
    "spoil",
    [
        lambda file: file.write_bytes(file.read_bytes()[:-100]),
        lambda file: write_table(read_table(file)[:3], file),
    ],
)
def test_a_damaged_file_is_simulated_again(done, spoil):
    study, out = done
    before = content(out)
    spoil(out / "runs" / "0000000004.parquet")
    with pytest.raises(
        br.core.InputError,
        match=r"contains files that are damaged or were not written here: runs/0000000004\.parquet",
    ):
        runs_in(out)
    with pytest.warns(
        br.core.InputWarning,
        match=r"out/runs/0000000004\.parquet is damaged.*bristle keeps it as .*\.damaged, and writes",
    ):
        assert run_study(study, out, workers=1).before == 2
    assert content(out) == before
    assert runs_in(out).count == study.count


@pytest.mark.parametrize(
    ("name", "step"), [("runs/0000000004.parquet", 997), ("study.json", 331), (NOTE, 257)]
)
def test_every_bit_of_a_study_is_guarded(done, name, step):
    study, out = done
    file = out / name
    whole = file.read_bytes()
    for bit in range(0, 8 * len(whole), step):
        data = bytearray(whole)
        data[bit // 8] ^= 1 << bit % 8
        file.write_bytes(data)
        with pytest.raises(br.core.InputError, match=re.escape(file.stem)):
            runs_in(out)
        if file.suffix != ".parquet":
            with pytest.raises(br.core.InputError, match=re.escape(name)):
                run_study(study, out, workers=1)
    file.write_bytes(whole)
    assert run_study(study, out, workers=1).before == 3


def test_a_whole_block_in_the_place_of_another_one_is_refused(done):
    runs = done[1] / "runs"
    (runs / "0000000004.parquet").write_bytes((runs / "0000000000.parquet").read_bytes())
    with pytest.raises(br.core.InputError, match=r"damaged.*0000000004"):
        runs_in(done[1])


def test_runs_without_the_description_of_their_study_are_continued_by_no_other_one(bench):
    out = bench.folder / "out"
    run_study(bench.study(), out, workers=1, provenance={})
    (out / "study.json").unlink()
    with pytest.raises(
        br.core.InputError,
        match=r"study\.json: is missing, and the runs in this folder do not identify",
    ):
        run_study(bench.study(change=("seed = 7", "seed = 8")), out, workers=1, provenance={})
    assert run_study(bench.study(), out, workers=1, provenance={}).before == 3


def test_a_persons_file_under_the_name_of_one_that_was_being_written_is_left_alone(done):
    study, out = done
    name = re.search(r"runs/bristle-[0-9a-f]{32}\.partial", (out / NOTE).read_text())[0]
    (out / name).write_text("mine")
    with pytest.raises(br.core.InputError, match=f"were changed: {name}"):
        run_study(study, out, workers=1)
    assert (out / name).read_text() == "mine"


def test_a_line_of_the_note_that_a_kill_cut_is_no_damage(done):
    study, out = done
    with (out / NOTE).open("a") as note:
        note.write('{"file": "runs/bristle-00')
    assert run_study(study, out, workers=1).before == 3
    assert run_study(study, out, workers=1).before == 3


def test_a_link_in_the_place_of_the_figures_is_refused(done, tmp_path):
    (_, out), mine = done, tmp_path / "mine"
    mine.mkdir()
    (out / "figures").symlink_to(mine)
    with (
        growing_folder(out, "study", used=lambda name: False) as (grown, _),
        pytest.raises(br.core.InputError, match="figures: is a link or a file"),
    ):
        grown.write("figures/mine.svg", "<svg/>")
    assert not list(mine.iterdir())


@pytest.mark.parametrize("name", ["study.json", "runs/0000000008.parquet", "report.html"])
def test_a_persons_own_file_of_a_name_that_the_study_uses_is_left_alone(done, name):
    study, out = done
    file = out / name
    file.parent.mkdir(exist_ok=True)
    file.unlink(missing_ok=True)
    file.write_text("a year of work")
    if name.startswith("runs"):  # it stands where a block was: it is kept beside the new one
        with pytest.warns(br.core.InputWarning, match="is damaged"):
            run_study(study, out, workers=1)
        file = file.with_name(f"{file.name}.damaged")
    else:
        before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
        with pytest.raises(
            br.core.InputError, match=rf"(were changed|did not write): {re.escape(name)}"
        ):
            run_study(study, out, workers=1)
        assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert file.read_text() == "a year of work"


def test_a_link_is_never_written_through(done, tmp_path):
    (study, out), mine = done, tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("years")
    for path in (out / "runs").iterdir():
        path.unlink()
    (out / "runs").rmdir()
    (out / "runs").symlink_to(mine)
    with pytest.raises(br.core.InputError, match="did not write: runs"):
        run_study(study, out, workers=1)
    assert [path.name for path in mine.iterdir()] == ["thesis.tex"]


def test_the_folder_may_be_a_link(bench):
    (bench.folder / "disk").mkdir()
    (bench.folder / "out").symlink_to(bench.folder / "disk")
    assert run_study(bench.study(), bench.folder / "out", workers=1).is_whole
    assert (bench.folder / "disk" / "study.json").is_file()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("seed = 7", "seed = 8"), "seed was 7 and is now 8"),
        (('"0.1 N"', '"0.2 N"'), r'vary\.friction\.F_C\.normal was \["1 N", "0\.1 N"\] and is now'),
        (("block = 4", "block = 6"), "block was 4 and is now 6"),
        ((', "effort.rms"', ""), "keep.metrics was"),
        (("substeps = 2", "substeps = 3"), r"the file of experiment, rig\.toml, has changed"),
    ],
)
def test_another_study_is_refused_with_its_differences(bench, done, change, told):
    _, out = done
    before = content(out)
    for file in (bench.folder / "study.toml", bench.folder / "rig.toml"):
        file.write_text(file.read_text().replace(*change))
    with pytest.raises(br.core.InputError, match=f"contains another study: {told}"):
        run_study(read_study_file(bench.folder / "study.toml"), out, workers=1)
    assert content(out) == before


def test_a_name_alone_makes_no_other_study(bench, done):
    named = bench.study(change=("schema = 1", 'schema = 1\nname = "Tolerances"'))
    assert run_study(named, bench.folder / "out", workers=1).before == 3


@pytest.mark.parametrize(
    "custom", ["thesis.tex", "report.html", "runs/2024.csv", "figures/draft.txt"]
)
def test_a_name_that_a_study_uses_too_is_a_persons_where_there_is_no_study(bench, custom):
    file = bench.folder / "mine" / custom
    file.parent.mkdir(parents=True)
    file.write_text("years")
    with pytest.raises(
        br.core.InputError, match=f"is not a folder of a study, but contains {custom}"
    ):
        run_study(bench.study(), bench.folder / "mine", workers=1)
    assert file.read_text() == "years"


def test_remains_of_a_study_that_ended_before_its_start_do_not_matter(bench):
    (bench.folder / "out").mkdir()
    (bench.folder / "out" / NOTE).write_bytes(b"")
    assert run_study(bench.study(), bench.folder / "out", workers=1).is_whole


@pytest.mark.parametrize("kind", ["notes", "link", "folder"])
def test_a_persons_file_under_the_name_of_a_block_to_come_is_set_aside(bench, done, kind):
    study, out = done
    whole, block = content(out), out / "runs" / "0000000004.parquet"
    with opened(bench.folder / "part", study, {}):
        pass
    place = bench.folder / "part" / "runs" / block.name
    if kind == "notes":
        place.write_text("a year of work")
    elif kind == "link":
        place.symlink_to(block)
    else:
        place.mkdir()
    with pytest.warns(
        br.core.InputWarning,
        match=rf"{re.escape(str(place))} is damaged, or .* keeps it as runs/{block.name}\.damaged",
    ):
        assert run_study(study, bench.folder / "part", workers=1).before == 0
    aside = place.with_name(f"{block.name}.damaged")
    assert (aside.is_file(), aside.is_symlink(), aside.is_dir()) == (
        kind != "folder",
        kind == "link",
        kind == "folder",
    )
    assert kind == "folder" or aside.read_bytes() == (
        b"a year of work" if kind == "notes" else block.read_bytes()
    )
    assert content(bench.folder / "part") == content(out) == whole
    assert runs_in(bench.folder / "part").count == study.count
    assert run_study(study, bench.folder / "part", workers=1).before == 3


@pytest.mark.parametrize("kind", ["link", "folder"])
def test_a_block_that_became_something_else_is_set_aside_once(done, kind):
    study, out = done
    before, block = content(out), out / "runs" / "0000000004.parquet"
    block.unlink()
    if kind == "link":
        block.symlink_to(out / "study.json")
    else:
        block.mkdir()
    with pytest.warns(br.core.InputWarning, match="is damaged") as warned:
        assert run_study(study, out, workers=1).before == 2
    assert len(warned) == 1
    assert block.with_name(f"{block.name}.damaged").is_symlink() is (kind == "link")
    assert content(out) == before


def test_a_foreign_file_among_the_runs_is_refused(bench, done):
    (bench.folder / "out" / "runs" / "more.parquet").write_bytes(b"")
    with pytest.raises(br.core.InputError, match=r"did not write: runs/more\.parquet"):
        run_study(bench.study(), bench.folder / "out", workers=1)


def test_a_full_disk_ends_a_study_cleanly_and_free_space_continues_it(bench, monkeypatch):
    study, rename = bench.study(), Folder.rename
    room = iter([True, True, False])

    def put_where_there_is_room(self, old, new):
        if not next(room):
            raise OSError(errno.ENOSPC, "No space left on device")
        rename(self, old, new)

    monkeypatch.setattr(Folder, "rename", put_where_there_is_room)
    with pytest.raises(br.core.InputError, match=r"no space left on device.*Make room"):
        run_study(study, bench.folder / "out", workers=1)
    assert sorted(content(bench.folder / "out")) == ["0000000000.parquet"]
    assert not list(bench.folder.rglob("*.partial"))
    monkeypatch.undo()
    assert run_study(study, bench.folder / "out", workers=1).before == 1


HOLDS = """
import sys, time
from pathlib import Path
from bristle.apps.study import read_study_file
from bristle.apps.study.store import opened
with opened(Path(sys.argv[2]), read_study_file(sys.argv[1]), {}):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="locks of POSIX")
def test_one_process_at_a_time_writes_and_a_stale_lock_is_ignored(bench):
    study, out = bench.study(), bench.folder / "out"
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS, bench.folder / "study.toml", out], stdout=subprocess.PIPE
    ) as holder:
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(
            br.core.InputError,
            match=rf"another process \(process {holder.pid}\) is writing to this folder",
        ):
            run_study(study, out, workers=1)
        holder.kill()
    assert run_study(study, out, workers=1).is_whole


def test_a_description_that_cannot_be_read_is_reported(tmp_path):
    with pytest.raises(br.core.InputError, match="is not the folder of a study"):
        study_in(tmp_path)
    for text, words in (
        ("{", "cannot be read"),
        ("[]", "has a format that this"),
        ('{"schema": 2}', "has a format that this"),
    ):
        (tmp_path / "study.json").write_text(text)
        with pytest.raises(br.core.InputError, match=words):
            study_in(tmp_path)
    (tmp_path / "study.json").write_text('{"schema": 1, "a": 2}')
    assert study_in(tmp_path)["a"] == 2


def refused(before, now):
    with pytest.raises(br.core.InputError) as error:
        refuse_another(before, now, Path("out"))
    return str(error.value)


def test_the_first_difference_is_named_and_the_rest_counted():
    single = refused({"study": {"seed": 7}}, {"study": {"seed": 8}})
    assert "contains another study: seed was 7 and is now 8" in single
    assert "more" not in single
    two = refused(
        {"study": {"seed": 7, "runs": 1}, "block": 4}, {"study": {"seed": 8, "runs": 2}, "block": 4}
    )
    assert "seed was 7 and is now 8, and there is 1 more difference" in two
    three = refused({"a": 1, "b": 1, "c": 1}, {"a": 2, "b": 2, "c": 2})
    assert "and there are 2 more differences" in three
    assert "a was missing and is now 3" in refused({"study": {}}, {"study": {"a": 3}})
    assert "the file of axis, a.toml, has changed" in refused(
        {"files": {"axis: a.toml": "1"}}, {"files": {"axis: a.toml": "2"}}
    )
    assert refuse_another({"a": {"b": 1}}, {"a": {"b": 1}}, Path("out")) is None


@pytest.mark.parametrize(("letters", "cut"), [(58, False), (59, True)])
def test_a_long_value_is_cut_visibly(letters, cut):
    text = refused({"study": {"a": "x" * letters}}, {"study": {"a": "y"}})
    assert ("…" in text) is cut
    assert f'a was "{"x" * 58}' in text


def test_a_new_study_has_no_runs(bench):
    out = bench.folder / "out"
    with opened(out, bench.study(), {}):
        pass
    runs = runs_in(out)
    assert runs.count == 0
    assert set(runs.columns) == set(bench.study().columns)
    assert runs.described["draws"] == 12
    assert runs.described["causes"] == {"friction.F_C": ["friction.F_C"], "plant.M": ["plant.M"]}
    assert runs.described["metrics"] == ["motion.peak_to_peak", "effort.rms"]


def test_reasons_survive_the_round_trip(bench):
    study, out = bench.study(level=('["1 N", "0.1 N"]', '["1 N", "1 N"]')), bench.folder / "out"
    run_study(study, out, workers=1)
    runs = runs_in(out)
    assert runs.columns["run"].tolist() == list(range(12))
    failed = runs.columns["status"] == "refused"
    assert 0 < failed.sum() < 12
    assert all(
        bool(reason) == bool(fault)
        for reason, fault in zip(runs.columns["reason"], failed, strict=True)
    )
    assert np.all(np.isnan(runs.columns["effort.rms"]) == failed)


# --- as a labelled data set ------------------------------------------------------------------------------------------


GRID = STUDY.replace("[keep]", '[grid]\n"effort.frequency" = ["2 Hz", "4 Hz"]\n[keep]').replace(
    "runs = 12", "runs = 4"
)


def test_a_study_is_read_with_its_units(bench):
    run_study(bench.study(), bench.folder / "out", workers=1)
    data = br.read_study(bench.folder / "out")
    assert dict(data.sizes) == {"run": 12}
    assert data["friction.F_C"].attrs == {"units": "N", "role": "drawn"}
    assert data["motion.peak_to_peak"].attrs["units"] == "m"
    assert (data.run.values.tolist(), set(data.status.values), data.attrs["seed"]) == (
        list(range(12)),
        {"ok"},
        7,
    )


def test_a_grid_becomes_dimensions(bench):
    run_study(bench.study(GRID), bench.folder / "out", workers=1)
    data = br.read_study(bench.folder / "out")
    assert dict(data.sizes) == {"draw": 4, "effort.frequency": 2}
    assert data["effort.frequency"].values.tolist() == [2.0, 4.0]
    assert data["effort.frequency"].attrs["units"] == "Hz"
    assert data["run"].values.tolist() == [[0, 1], [2, 3], [4, 5], [6, 7]]
    # One draw is the same at both frequencies, and its axis moves differently.
    assert np.all(data["friction.F_C"].values[:, 0] == data["friction.F_C"].values[:, 1])
    assert np.all(
        data["motion.peak_to_peak"].values[:, 0] != data["motion.peak_to_peak"].values[:, 1]
    )


def test_missing_runs_are_nan(bench):
    run_study(bench.study(GRID), bench.folder / "out", workers=1)
    (bench.folder / "out" / "runs" / "0000000004.parquet").unlink()
    data = br.read_study(bench.folder / "out")
    assert data["run"].values[2:].tolist() == [[-1, -1], [-1, -1]]
    assert np.all(np.isnan(data["motion.peak_to_peak"].values[2:]))
    assert np.all(np.isfinite(data["motion.peak_to_peak"].values[:2]))


def test_a_folder_without_a_study_is_refused(tmp_path):
    with pytest.raises(br.core.InputError, match=r"has no study[.]json"):
        br.read_study(tmp_path)


def test_without_pyarrow_the_install_command_is_shown(bench, monkeypatch):
    run_study(bench.study(), bench.folder / "out", workers=1)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for message in (
        lambda: br.read_study(bench.folder / "out"),
        lambda: run_study(bench.study(), bench.folder / "new"),
    ):
        with pytest.raises(
            br.core.errors.MissingExtraError,
            match=r'bristle study .* pip install "bristle\[study\]"',
        ):
            message()
