"""Commands on a machine: ``bristle tune``."""

from pathlib import Path

from bristle.apps.tune.journal import Journal

RIG = Path(__file__).parents[2] / "examples/tune/machine.toml"


def test_a_machine_without_memory_is_refused_by_name(bristle, tmp_path, monkeypatch):
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    (tmp_path / "out").mkdir()
    Journal(tmp_path / "out").write("verdict", "begun", file=str(RIG))
    bristle(
        "tune",
        "--save",
        str(tmp_path / "out"),
        code=1,
        said="the machine experiment has no non-volatile memory",
    )
