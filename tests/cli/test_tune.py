"""``bristle tune --save``: a kept feedforward in non-volatile memory."""

from pathlib import Path

from bristle.tune.journal import Journal

RIG = Path(__file__).parents[2] / "examples/tune/machine.toml"


def test_a_machine_without_memory_is_refused_by_name(bristle, tmp_path, monkeypatch):
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    (tmp_path / "out").mkdir()
    Journal(tmp_path / "out").write("verdict", "begun", file=str(RIG))
    ended = bristle("tune", "--save", str(tmp_path / "out"))
    assert ended.code == 1
    assert "the machine experiment has no non-volatile memory" in " ".join(ended.err.split())
