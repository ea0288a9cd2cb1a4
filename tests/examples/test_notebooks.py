"""The notebooks of the gallery run, show their figures, and print what their sentences say."""

import json
import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from tests.examples.data import values_of

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[2] / "examples" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.fixture
def run(capsys, tmp_path, monkeypatch):
    """Run a notebook in an empty folder; return what its cells show, and what they print."""
    monkeypatch.chdir(tmp_path)

    def executed(name):
        shown = values_of(FOLDER / f"{name}.ipynb")
        assert list(tmp_path.iterdir()) == []
        return shown, capsys.readouterr().out

    return executed


def numbers(pattern, text):
    return [float(number.replace("−", "-")) for number in re.search(pattern, text).groups()]


def figures_in(shown):
    """How many figures a notebook shows as pictures: those that draw themselves, and those of pyplot."""
    figures = [value for value in shown if isinstance(value, Figure)]
    return sum(hasattr(figure, "_repr_svg_") or hasattr(figure, "number") for figure in figures)


def test_each_notebook_is_small_stripped_listed_and_tested():
    page, asserted = (
        (FOLDER / "README.md").read_text(encoding="utf-8"),
        Path(__file__).read_text(encoding="utf-8"),
    )
    assert len(NOTEBOOKS) >= 3
    for notebook in NOTEBOOKS:
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        assert 6 <= len(cells) <= 12, notebook
        assert all(not cell.get("outputs") and not cell.get("execution_count") for cell in cells), (
            notebook
        )
        assert f"({notebook.name})" in page
        assert notebook.with_suffix(".png").is_file()
        assert f'run("{notebook.stem}")' in asserted


def test_which_model_drifts(run):
    shown, printed = run("which_model_drifts")
    assert figures_in(shown) == 2
    (walked,) = numbers(r"LuGre +drifts +([\d.]+) nm", printed)
    first, last = numbers(r"LuGre +from +([\d.]+) um to +([\d.]+) um", printed)
    # What is certified of a cycle is what 28 kg do, shaken twice a second for half a minute: 59 cycles.
    assert last - first == pytest.approx(59 * 1e-3 * walked, rel=0.03)
    for name in ("Maxwell slip", "Preisach with a gate"):
        assert numbers(rf"{name} +drifts +([\d.]+) nm", printed) == [0.0]
        first, last = numbers(rf"{name} +from +([\d.]+) um to +([\d.]+) um", printed)
        assert last == pytest.approx(first, abs=0.02)


def test_limit_cycle(run):
    shown, printed = run("limit_cycle")
    assert figures_in(shown) == 2
    rolling, stuck = numbers(r"rolling: +(\S+) 1/s\nstuck: +(\S+) 1/s", printed)
    assert rolling < 0.0 < stuck
    amplitude, frequency = numbers(r"predicted (\S+) % and (\S+) %", printed)
    assert abs(amplitude) < 1.5
    assert abs(frequency) < 0.4
    nearest, hunted = numbers(
        r"nearest to a balance: ([\d.]+); the axis hunts by (\d+) um", printed
    )
    assert nearest > 0.1
    assert hunted > 200.0


def test_log_to_loop(run):
    shown, printed = run("log_to_loop")
    assert figures_in(shown) == 2
    identified = next(value for value in shown if hasattr(value, "parameters"))
    assert identified.best.name == "lugre+asymmetry"
    assert identified.parameters["M"].value == pytest.approx(28.0, rel=0.01)
    assert float(next(value for value in shown if isinstance(value, str)).split()[0]) < 3.0
    loop = next(value for value in shown if hasattr(value, "variants")).variants
    errors = [
        loop[name].following_error.peak_to_peak
        for name in ("as_recorded", "feedforward", "compensated")
    ]
    assert errors[0] > 10.0 * errors[1] > 30.0 * errors[2]  # 0.7 of the friction is fed forward
    assert 4 <= printed.count(" N\n") <= 8
