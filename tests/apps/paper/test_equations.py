"""The equations of the paper: none is missing, each is computed where it is said, tested, and can be run."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import typer
from matplotlib.mathtext import MathTextParser

from bristle.apps.paper import FIGURES, equations, reproduce, setting, write_experiments
from bristle.cli.application import application
from bristle.cli.main import main
from bristle.engine import interpreted

ROOT = Path(__file__).parents[3]
GROUP = typer.main.get_command(application())
CHEAP = "bristle models"  # the others take seconds to minutes, and have their own tests
each = pytest.mark.parametrize(
    "one", equations.EQUATIONS, ids=lambda equation: str(equation.number)
)


def numbers_in(text):
    """The equations that a text names, (5) to (7) in full."""
    result = {int(item) for item in re.findall(r"\((\d+)\)", text)}
    for first, last in re.findall(r"\((\d+)\) to \((\d+)\)", text):
        result |= set(range(int(first), int(last) + 1))
    return result


def test_all_23_are_there_in_order():
    assert [equation.number for equation in equations.EQUATIONS] == list(range(1, 24))


@each
def test_the_computing_file_names_the_equation(one):
    text = (ROOT / "src" / "bristle" / one.file).read_text(encoding="utf-8")
    assert one.number in numbers_in(text.partition('"""')[2].partition('"""')[0])


@each
def test_the_test_of_each_equation_exists(one):
    file, _, name = one.test.partition("::")
    assert re.search(
        rf"^def {name}\(", (ROOT / "tests" / file).read_text(encoding="utf-8"), re.MULTILINE
    )


@each
def test_only_equations_marked_as_corrected_differ(one):
    assert (one.stands == "as printed") == (not one.formula)
    assert one.formula != one.printed
    assert "|" not in one.printed + one.formula  # it would end the cell


@each
def test_formulas_can_be_typeset(one):
    # Of the usual TeX this parser knows all but a few words that do not change the sense.
    for formula in filter(None, (one.printed, one.formula)):
        plain = formula.replace(r"\tfrac12", r"\frac{1}{2}").replace(r"\frac1J", r"\frac{1}{J}")
        plain = re.sub(r"\\lvert|\\rvert", "|", plain).replace(r"\text{", r"\mathrm{")
        MathTextParser("path").parse(f"${plain}$")


@pytest.fixture(scope="module")
def session():
    names = {}
    for line in equations.SETUP:
        exec(line, names)
    return names


@pytest.mark.parametrize(
    "equation",
    [equation for equation in equations.EQUATIONS if equation.gives],
    ids=lambda equation: str(equation.number),
)
@interpreted()
def test_the_python_line_gives_the_stated_result(equation, session):
    assert str(eval(equation.run, session)) == equation.gives


@pytest.mark.parametrize(
    "command", sorted({equation.run for equation in equations.EQUATIONS if not equation.gives})
)
def test_the_command_can_be_run(command, tmp_path, monkeypatch, capsys):
    words = shlex.split(command)
    assert words.pop(0) == "bristle"
    context = GROUP.make_context("bristle", [], resilient_parsing=True)
    name, result, arguments = GROUP.resolve_command(context, words)
    parsed = result.make_context(name, list(arguments), parent=context)
    assert set(parsed.params.get("figure") or ()) <= set(FIGURES)
    if command.startswith(CHEAP):
        monkeypatch.chdir(tmp_path)
        assert main(words) == 0, capsys.readouterr().err


# --- The numbers that the pages tell of the source paper are those that come out


PAGE = (ROOT / "docs/theory/the-source-paper.md").read_text(encoding="utf-8").replace("−", "-")


@pytest.mark.slow
def test_the_experiment_in_the_docs_runs(tmp_path):
    page = (ROOT / "docs/how-to/contact-experiment.md").read_text(encoding="utf-8")
    texts = re.findall(r"```toml contact\n(.*?)```", page, re.DOTALL)
    custom = write_experiments(tmp_path / "mine")[0].with_name("fig_08.toml")
    result, on_bench = [
        custom.write_text(text, encoding="utf-8") and setting.read_setting(custom) for text in texts
    ]
    assert reproduce([8], folder=custom.parent)[0].verdict == "calibrated"
    assert set(on_bench.numbers["bench"]) == set(setting.SECTIONS["bench"])
    assert list(result.contacts) == ["LuGre", "virtual rig"]
    assert result.contacts["virtual rig"].values["scatter"] == 0.0
    message = set(re.findall(r"^\| `\[(\w+)", page, re.MULTILINE))
    assert message == {"contact", "operator", "plant", *setting.SECTIONS}
    for keys in setting.SECTIONS.values():
        assert all(f"`{key}`" in page for key in keys)


def row(first):
    """The numbers of the row of a table that begins so, its first cell left out."""
    cells = next(line for line in PAGE.splitlines() if line.startswith(f"| {first} |")).split("|")[
        2:-1
    ]
    return [
        float(item) for cell in cells for item in re.findall(r"(?<![\w(])-?\d+(?:\.\d+)?", cell)
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "key", "place"),
    [
        ("1", "error_percent", 0),
        ("10", "error_percent", 3),
        ("100", "error_percent", 4),
        ("1, no scatter", "error_percent_without_scatter", 0),
        ("100, no scatter", "error_percent_without_scatter", 4),
    ],
)
def test_the_errors_over_branches(first, key, place, paper):
    lines = [line for line in PAGE.splitlines() if line.startswith(f"| {first} |")]
    message = [cell.strip() for cell in lines[-1].split("|")[2:-1]]
    result = [float(number[place]) for number in paper[6].numbers[key].values()]
    for text, value in zip(message, result, strict=True):
        mean, _, _ = text.partition(" ± ")
        assert np.isnan(value) if text == "–" else float(mean) == pytest.approx(value, abs=0.06)
    if key == "error_percent":
        spread = [
            float(number[place]) for number in paper[6].numbers["error_deviation_percent"].values()
        ]
        deviations = [
            np.nan if text == "–" else float(text.partition(" ± ")[2]) for text in message
        ]
        assert deviations == pytest.approx(spread, abs=0.06, nan_ok=True)
    assert paper[6].numbers["scatter_percent"] == pytest.approx(2.3, abs=0.05)


@pytest.mark.slow
def test_the_loops_that_do_not_close(paper):
    missing = paper[1].numbers["missing_at_return"]
    lugre, printed, rig = row("1")[:3]
    result = [-100.0 * missing[name] for name in ("LuGre", "equations (5)–(7)", "virtual rig")]
    assert (lugre, printed, rig) == pytest.approx(result, abs=0.5)


@pytest.mark.slow
def test_the_drift(paper):
    drift = paper[2].numbers["drift_per_cycle"]
    step, more = row("2")[:2]
    assert 1e6 * drift["LuGre"] == pytest.approx(step, abs=0.005)
    assert 100.0 * (drift["equations (5)–(7)"] / drift["LuGre"] - 1.0) == pytest.approx(
        more, abs=0.5
    )


@pytest.mark.slow
def test_the_other_figures(paper):
    rests, apart, width = row("3")[:3]
    assert f"−{rests} ± {apart} nm per cycle" in paper[3].found[0]
    drift, share = (
        paper[3].numbers[key]["virtual rig"] for key in ("drift_per_cycle", "share_of_the_orbit")
    )
    assert 1e6 * abs(drift) / share == pytest.approx(width, abs=0.006)
    bottom, top, tip, wander = row("5")[:4]
    assert 1e3 * np.array(paper[5].numbers["largest_loop"]) == pytest.approx((bottom, top), abs=0.6)
    assert f"its forward tip is at {tip} ± {wander} mN·m" in " ".join(paper[5].found)
    share, at, spread, *printed = row("8")[1:]
    assert f"{share:.0f} % of it after {at} ± {spread} µm" in " ".join(paper[8].found)
    assert f"and reaches {printed[0]:.0f} % of it after {printed[1]:.1f} µm" in " ".join(
        paper[8].found
    )


@pytest.mark.slow
def test_wiping_out(paper):
    *message, apart, with_offset = row("9, 10")[2:]  # behind the numbers of both figures
    runs = [100.0 * number["B"] for number in paper[9].numbers["missing_of_runs"]["virtual rig"]]
    assert message[:2] == pytest.approx((np.mean(runs), np.std(runs, ddof=1)), abs=0.06)
    printed = paper[10].numbers["missing_at_return"]["equations (5)–(7)"]["B"]
    assert -100.0 * printed == pytest.approx(message[-1], abs=0.5)
    beside = paper[10].numbers["apart_from_rig"]["100 branches, over z"]
    assert 100.0 * beside["as_it_is"] == pytest.approx(apart, abs=0.5)
    assert 100.0 * beside["with_offset"] == pytest.approx(with_offset, abs=0.06)


@pytest.mark.slow
def test_how_far_the_torque_sensor_is_from_friction(paper):
    stated = r"error of this sensor is ([\d.]+) % .*? ([\d.]+) % with the torque of figure 3, and ([\d.]+) % at break-away"
    led, rippled, pushed = map(float, re.search(stated, PAGE, re.DOTALL).groups())
    for number in (5, 8, 9):
        assert 100.0 * paper[number].numbers["torque_sensor"]["apart"] == pytest.approx(
            led, abs=0.05
        )
    assert 100.0 * paper[3].numbers["torque_sensor"]["apart"] == pytest.approx(rippled, abs=0.05)
    assert 100.0 * paper[3].numbers["torque_sensor_at_break_away"]["apart"] == pytest.approx(
        pushed, abs=0.05
    )


@pytest.mark.slow
def test_the_tracking(paper):
    result, worse = paper[12].numbers, paper[12].numbers["forward_over_backward"]
    peaks, spreads = result["peak_to_peak"], result["peak_to_peak_spread"]
    before, after, less, forward = row("11, 12")[-4:]
    assert (1e6 * peaks["none"], 1e6 * peaks["printed"]) == pytest.approx(
        (before, after), abs=0.006
    )
    assert 100.0 * (1.0 - peaks["printed"] / peaks["none"]) == pytest.approx(less, abs=0.6)
    assert worse["printed"] == pytest.approx(forward, abs=0.006)
    means = [
        1e6 * paper[13].numbers[name][key]
        for key in ("std", "mean")
        for name in ("none", "printed")
    ]
    assert row("13") == pytest.approx(means, abs=0.006)
    rms = paper[14].numbers["rms"]
    assert 100.0 * (rms["printed"] / rms["none"] - 1.0) == pytest.approx(row("14")[0], abs=0.06)
    message = (ROOT / "README.md").read_text(encoding="utf-8")
    both = [f"{1e6 * peaks[name]:.2f} ± {1e6 * spreads[name]:.2f}" for name in ("none", "printed")]
    assert f"from {both[0]} to {both[1]} µm" in message


@pytest.mark.slow
def test_the_table_of_the_loop_of_the_paper(paper):
    peaks, spreads = (paper[12].numbers[key] for key in ("peak_to_peak", "peak_to_peak_spread"))
    rows = {
        "nothing": "none",
        "LuGre": "lugre",
        "(5)–(7) as printed": "printed",
        "the same, plus the constant that its loops lack": "printed_constant",
        "(5)–(7) with a gate": "gate",
        "operator on the position, × 0.64: calibrated": "paper",
        "Maxwell slip, identified from encoder and effort": "identified",
        "observer, no model": "observer",
        "observer and identified model": "observer_feedforward",
    }
    for shown, name in rows.items():
        assert f"| {shown} | {1e6 * peaks[name]:.2f} ± {1e6 * spreads[name]:.2f} |" in PAGE
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert (
        f"With a gate, which blocks slip at small forces, the error is {1e6 * peaks['gate']:.2f} µm"
        in readme
    )


@pytest.mark.slow
def test_the_errors_over_the_break_away_torque(paper):
    over = paper[12].numbers["over_break_away"]
    message = f"the error is {1e6 * over[0]['peak_to_peak']:.2f} to {1e6 * over[-1]['peak_to_peak']:.2f} µm"
    assert message in PAGE.replace("\n", " ")


@pytest.mark.slow
def test_the_gain_at_sound_margins(paper, faster):
    slow = paper[12].numbers["at_sound_margins"]
    message = (ROOT / "README.md").read_text(encoding="utf-8")
    rows = {
        "without": "none",
        "feedforward with a model, identified from a log of one minute": "identified",
        "observer without model": "observer",
        "feedforward and observer": "observer_feedforward",
    }
    for shown, name in rows.items():
        errors = [slow[name]["following_error"]]
        errors += [faster[f"{name}_{speed}hz"].as_dict()["following_error"] for speed in (1, 2, 4)]
        cells = [
            f"{1e6 * error['peak_to_peak']:.2f} ± {1e6 * error['peak_to_peak_spread']:.2f}"
            for error in errors
        ]
        assert f"| {shown} | {' | '.join(cells)} |" in message
    text = PAGE.replace("\n", " ")
    for name in ("observer", "observer_feedforward"):
        error, two, four = (
            1e6 * faster[f"{name}_{speed}hz"].following_error.peak_to_peak for speed in (1, 2, 4)
        )
        assert f"{error:.2f}, {two:.2f} and {four:.2f} µm" in text
