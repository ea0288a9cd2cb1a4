"""``bristle predict``: errors of a prediction, and what each mode needs."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import written_in

from bristle.files import provenance, read_axis
from bristle.logs import read_log

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.mark.parametrize(("mode", "effort", "position"), [("inverse", 5.0, None), ("closed-loop", 5.0, 0.1), ("open-loop", None, 50.0)])
def test_each_mode_names_its_prediction(bristle, place, mode, effort, position):
    result = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--mode", mode, "--json")
    assert result.code == 0
    metrics = result.data["metrics"]
    assert set(metrics) == {"force_error_percent", "force_rmse", "force_unit", "position_error_percent", "position_rmse", "position_unit"}
    for key, limit in (("force_error_percent", effort), ("position_error_percent", position)):
        assert (metrics[key] is None) == (limit is None)
        assert limit is None or 0.0 < metrics[key] < limit
    assert metrics["position_unit"] == "m"


def test_a_wrong_model_predicts_worse(bristle, place):
    right = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    Path("model.toml").write_text(Path("model.toml").read_text().replace("F_C = 8.0", "F_C = 4.0"))
    wrong = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    assert wrong["metrics"]["force_error_percent"] > 2.0 * right["metrics"]["force_error_percent"]


def test_results_and_words(bristle, place):
    result = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--mode", "closed-loop", "--out", "run")
    assert result.code == 0
    assert result.out.startswith("The model is valid")
    assert "Effort error" in result.out
    assert written_in("run") == {"summary.json", "report.html"}
    assert json.loads(Path("run/summary.json").read_text())["mode"] == "closed-loop"


def test_a_diverging_loop_exits_with_1(bristle, place):
    axis = Path("axis.toml")
    axis.write_text(axis.read_text().replace('"4 N*s/mm"', '"400 N*s/mm"').replace('limit = "300 N"', ""))
    ended = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--mode", "closed-loop", "--json")
    assert ended.code == 1
    assert ended.data["completed"] is False
    assert ended.data["metrics"]["force_error_percent"] is None


def test_a_prediction_of_the_fitted_log_itself_causes_a_note(bristle, place):
    table = np.loadtxt("log.csv", delimiter=",", skiprows=1)
    np.savetxt("both.csv", np.hstack([table, table[:, 1:]]), delimiter=",", header="t,q,r,u,q_b,r_b,u_b", comments="")
    Path("other.toml").write_text(re.sub('column = "([qru])"', r'column = "\1_b"', Path("axis.toml").read_text()))
    entries = provenance("bristle identify", log=read_log("both.csv", read_axis("axis.toml")))
    lines = [f"{name} = {json.dumps(value)}" for name, value in entries.items()]
    Path("model.toml").write_text("\n".join([Path("model.toml").read_text(), "[provenance]", *lines]))
    message = {}
    for name in ("axis.toml", "other.toml"):
        result = bristle("predict", "model.toml", "both.csv", "--axis", name, "--json")
        message[name] = "fitted to this log" in " ".join(result.data["verdict"]["reasons"])
    assert message == {"axis.toml": True, "other.toml": False}
