"""``bristle run``: variants side by side."""

import json
from pathlib import Path
from unittest.mock import ANY

import numpy as np
import pytest
from tests.cli.conftest import written_in

import bristle as br

pytestmark = pytest.mark.usefixtures("undrawn")


def test_results_and_words(bristle, place):
    bristle("run", "experiment.toml", "--out", "run", code=0, shown=("base", "none"))
    assert written_in("run") == {"summary.json", "report.html"}
    assert list(json.loads(Path("run/summary.json").read_text())["variants"]) == ["base", "none"]


def test_bad_settings_of_matplotlib_end_a_command_before_its_work(bristle, place, monkeypatch):
    def refused(name):
        raise br.core.InputError("cannot be imported with the settings of this machine", path="matplotlib")

    monkeypatch.setattr("bristle.cli.options.import_module", refused)
    monkeypatch.setattr("bristle.simulation.simulate", lambda *_: pytest.fail("simulated first"))
    bristle("run", "experiment.toml", "--out", "run", code=2, said="cannot be imported with the settings of this machine")
    assert not Path("run").exists()


def test_a_diverging_loop_exits_with_1_and_prints_no_nan(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(text.replace('"4 N*s/mm"', '"400 N*s/mm"').replace('limit = "300 N"', ""))
    ended = bristle(
        "run", "experiment.toml", "--json", "--out", "run", code=1, said=("base, none: unstable", "the sampled loop has a pole at")
    )
    assert ended.data["variants"]["base"]["completed"] is False
    assert ended.data["variants"]["none"] == {"status": ANY, "completed": False, "runs": 0}
    assert "the sampled loop has a pole at" in (Path("run") / "report.html").read_text()


def test_stable_variants_are_simulated_nevertheless(bristle, place):
    text = Path("experiment.toml").read_text()
    slow = "[compare.base]\n\n[compare.slow.run]\ndelay = 9\n\n"
    Path("experiment.toml").write_text(text.partition("[compare")[0] + slow)
    ended = bristle("run", "experiment.toml", "--json", code=1, said="slow: unstable")
    assert ended.data["variants"]["base"]["completed"] is True
    assert "nine samples of delay" in ended.data["variants"]["slow"]["status"]
    message = ended.data["diagnostics"][-1]
    assert (message["code"], message["severity"], message["numbers"]["variants"]) == ("loop_diverges", "error", ["slow"])
    assert ended.data["variants"]["slow"]["status"] == message["message"]


def test_a_small_margin_causes_a_warning(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(text.replace("[run]", "[run]\ndelay = 3"))
    ended = bristle("run", "experiment.toml", "--json", "--out", "run", code=0, said="base, none: warning: the phase margin is")
    assert "the phase margin is" in ended.data["warnings"][0]
    message = ended.data["diagnostics"][0]
    assert (message["code"], message["severity"]) == ("small_margin", "warning")
    assert message["numbers"]["variants"] == ["base", "none"]
    assert ended.data["warnings"][0] == f"base, none: warning: {message['message']}"
    assert 0.0 < message["numbers"]["phase"] < message["numbers"]["enough"]
    assert "the phase margin is" in (Path("run") / "report.html").read_text()


def test_a_user_model_runs_from_its_file(bristle, place):
    text = Path("experiment.toml").read_text()
    text = text.replace('model = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"', 'file = "own.py"\nF_0 = "8 N"')
    Path("experiment.toml").write_text(text)
    bristle("run", "experiment.toml", "--json", code=2, said=("needs permission to run: own.py (SHA-256 ", "--allow-code"))
    result = bristle("run", "experiment.toml", "--allow-code", "--json", code=0)
    assert result.data["variants"]["none"]["completed"] is True
    assert result.data["provenance"]["code"] == "own.py"
    assert result.err.startswith("bristle: warning: friction.file: the code in own.py (SHA-256 ")
    assert bristle("run", "experiment.toml").code == 2  # asked for once, allowed once


def test_the_log_of_each_variant_is_written(bristle, place):
    result = bristle("run", "experiment.toml", "--log", "--out", "run", "--json")
    assert result.data["files"] == {"base": "log_base.csv", "none": "log_none.csv"}
    log = br.read_log("run/log_base.csv")
    assert (log.effort.unit, log.position.unit) == ("N", "m")
    settled = np.abs(log.effort.values[log.time.values >= 2.0])
    assert np.max(settled) == pytest.approx(result.data["variants"]["base"]["effort"]["peak"])
    # A folder with logs is one of results: it can be replaced.
    assert bristle("run", "experiment.toml", "--out", "run", "--force").code == 0
    assert not Path("run/log_base.csv").exists()


def test_a_log_in_the_columns_of_the_axis_is_read_with_it_and_a_motion_is_followed(bristle, place):
    (place / "motion.csv").write_text("t [s],r [m]\n" + "".join(f"{1e-3 * k},{2e-2 * np.sin(6e-3 * k)}\n" for k in range(1000)))
    text = Path("experiment.toml").read_text().partition("[compare")[0]
    rest = text.partition("[reference]")
    follow = '[reference]\nmodel = "recorded"\nfile = "motion.csv"\n'
    Path("follow.toml").write_text(f'{rest[0]}[axis]\nfile = "axis.toml"\n{follow}')
    result = bristle("run", "follow.toml", "--log", "--out", "run", "--json", code=0)
    assert result.data["files"] == {"base": "log.csv"}
    log = br.read_log("run/log.csv", br.read_axis("axis.toml"))
    assert log.reference.values == pytest.approx(2e-2 * np.sin(6e-3 * np.arange(1000)), abs=1e-12)
    assert log.position.values == pytest.approx(log.reference.values, abs=2e-3)
    assert log.effort.column == "u"


@pytest.mark.parametrize("command", ["run", "design"])
def test_an_experiment_on_a_contact_is_refused_with_its_command(bristle, tmp_path, command):
    assert bristle("paper", "--write", tmp_path / "my copy").code == 0
    ended = bristle(command, tmp_path / "my copy/fig_03.toml", code=2, said="is an experiment on a contact")
    assert ended.err.count("\n") == 1
    assert f"bristle paper --from '{tmp_path / 'my copy'}' --figure 3\n" in ended.err


def test_an_experiment_on_a_contact_is_recognized_by_its_tables(bristle, place):
    Path("mine.toml").write_text('schema = 1\n[contact.a]\nmodel = "dahl"\n[path]\nturns = ["1 um"]\n')
    assert "bristle paper --from . --figure N" in bristle("run", "mine.toml").err
    text = Path("experiment.toml").read_text()
    Path("fig_01.toml").write_text(text)
    assert bristle("run", "fig_01.toml").code == 0
    # A loop with a table that it has not is one that was mistyped.
    Path("experiment.toml").write_text(text + '\n[path]\nturns = ["1 um"]\n')
    assert "path: unknown key" in bristle("run", "experiment.toml").err


def test_the_best_variant_is_named_last(bristle, place):
    text = Path("experiment.toml").read_text().replace("[compare.none.", "[compare.base]\n\n[compare.none.")
    Path("experiment.toml").write_text(f"{text}\n[compare.half.controller.feedforward]\ngain = 0.5\n")
    result = bristle("run", "experiment.toml")
    words = " ".join(result.out.split())
    assert "No variant is better than base: " in words
    fed = 'friction = { model = "coulomb_viscous", F_C = "8 N", F_v = "40 N*s/m" }'
    text = text.replace(fed, "", 1).replace('friction = "none"', fed)
    for velocity, less in (("", "hardly less."), ("\nk_ff = 1", "% less.")):
        # With the lag of the position loop gone, most of the error is friction.
        Path("experiment.toml").write_text(text.replace('k_p = "80 1/s"', f'k_p = "80 1/s"{velocity}'))
        words = " ".join(bristle("run", "experiment.toml").out.split()).replace("\u00a0", " ")
        assert "The best variant is none: " in words
        assert less in words


def test_a_compensator_identified_on_another_rig_is_reported(bristle, tmp_path):
    assert bristle("paper", "--write", tmp_path / "mine").code == 0
    rig, short = tmp_path / "mine" / "set_a_rig.toml", tmp_path / "mine" / "short.toml"
    rig.write_text(rig.read_text(encoding="utf-8").replace("scatter = 0.05", "scatter = 0.08"), encoding="utf-8")
    text = (tmp_path / "mine" / "set_c.toml").read_text(encoding="utf-8")
    brief = text.replace("seeds = 6", "seeds = 1").replace('duration = "28 s"', 'duration = "3 s"')
    short.write_text(brief, encoding="utf-8")
    message = " ".join(bristle("run", short).err.split())
    assert "identified: the friction model of its compensator was identified on a different friction" in message
    assert "observer: the friction model of its compensator" not in message
