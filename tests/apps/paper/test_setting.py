"""Experiments on a contact: what the files say is what is moved, and a bad file says where."""

import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from bristle import friction
from bristle.apps.paper import EXPERIMENTS, FIGURES, bench, reproduce, write_experiments
from bristle.apps.paper.setting import KEYS, SECTIONS, _number, _numbers, read_setting
from bristle.core.errors import InputError
from bristle.files import read_experiment


def written(folder, text, name="fig_01.toml"):
    path = folder / name
    path.write_text(text)
    return path


def changed(folder, old, new, name="fig_01.toml"):
    write_experiments(folder / "paper")
    path = folder / "paper" / name
    text = path.read_text(encoding="utf-8")
    other = old.sub(new, text) if isinstance(old, re.Pattern) else text.replace(old, new)
    assert other != text
    path.write_text(other, encoding="utf-8")
    return path


def test_lengths_are_those_of_the_table_and_torques_those_of_the_screw(tmp_path):
    path = written(
        tmp_path, 'schema = 1\nlead = "10 mm"\n[path]\nturns = ["1 um"]\n[torque]\nlow = "3 mN*m"\n'
    )
    result = read_setting(path)
    assert result.arm == pytest.approx(0.01 / (2.0 * np.pi))
    assert result["path", "turns"] == pytest.approx([1e-6])
    assert result["torque", "low"] == pytest.approx(3e-3)


WITHOUT_OPERATOR = re.compile(r"\[operator.*(?=\[path\])", re.DOTALL)


@pytest.mark.parametrize(
    ("number", "old", "new", "said"),
    [
        (1, "schema = 1", "", "schema"),
        (1, "turns = [", "turn = [", "path.turn"),
        (1, '"2 um/s"', '"2 mN*m"', "path.speed"),
        (1, '["3 um", "1.5 um", "3 um", "5 um"]', '"3 um"', "path.turns"),
        (1, '["3 um", "1.5 um", "3 um", "5 um"]', '["3 um", "1.5 um"]', "path.turns"),
        (1, '["3 um", "1.5 um", "3 um", "5 um"]', '["3 um", "x"]', r"path.turns\[1\]"),
        (1, '["3 um", "1.5 um", "3 um", "5 um"]', '["3 um", "11 mm"]', r"path.turns\[1\]"),
        (
            1,
            '["3 um", "1.5 um", "3 um", "5 um"]',
            '["3 um", "-4611686018427387904"]',
            r"path.turns\[1\]",
        ),
        (1, 'model = "lugre"', 'model = "lugra"', "contact.LuGre.model"),
        (1, 'file = "set_a_rig.toml"', 'file = "no_rig.toml"', "no_rig.toml"),
        (1, "[path]", "[way]", "way"),
        (2, '[plant]\nmodel = "inertia"\nM = "631.65 kg"', "", "plant"),
        (2, 'low = "12.3 mN*m"', 'low = "30 mN*m"', "torque"),
        (4, '"-2.5 um"', '"5 um"', "path.turns"),
        (5, '[contact."virtual rig"]', "[contact.rig]", "virtual rig"),
        (9, '"4.5 um", "6 um"', '"4.5 um", "6.1 um"', "path.turns"),
        (2, "[contact.LuGre]", "[contact.other]", "contact.LuGre"),
        (2, "cycles = 10", "cycles = 1.5", "torque.cycles"),
        (2, "cycles = 10", "cycles = 10001", "torque.cycles"),
        (6, "branches = [1, 2", "branches = [10001, 2", "measurement.branches"),
        (3, '[contact."virtual rig"]', "[contact.rig]", "virtual rig"),
        (4, "[operator.f_h]", "[contact.f_h]", "contact.f_h"),
        (6, "branches = [1, 2", "branches = [0, 2", "measurement.branches"),
        (6, "seeds = 6", "seeds = 2.5", "measurement.seeds"),
        (8, '["14 um"]', '["-14 um"]', "path.turns"),
        (3, "[bench]", "[plant]", "plant"),
        (3, 'J = "4e-4 kg*m^2"', "", "bench.J"),
        (5, "[bench]", "[bank]", "bank"),
        (5, 'J_m = "2.5e-4 kg*m^2"', 'J_m = "4.5e-4 kg*m^2"', "bench.J_m"),
        (7, 'J_m = "2.5e-4 kg*m^2"', 'J_m = "-1 kg*m^2"', "bench.J_m"),
        (7, 'J_m = "2.5e-4 kg*m^2"', "", "bench.J_m"),
        (8, 'torque_filter = "200 Hz"', 'torque_filter = "0 Hz"', "bench.torque_filter"),
        (8, 'acceleration = "1 mm/s^2"', "", "bench.acceleration"),
        (9, 'acceleration = "1 mm/s^2"', 'acceleration = "1 mm/s"', "bench.acceleration"),
        (9, "seeds = 6", "", "measurement.seeds"),
        (10, '[contact."virtual rig"]', "[contact.rig]", "virtual rig"),
        (4, WITHOUT_OPERATOR, "", "operator: is missing"),
        (
            11,
            "[compare.paper.controller.feedforward]",
            "[compare.other.controller.feedforward]",
            "compare.paper",
        ),
        (11, "seeds = 6", "seeds = x", "set_a.toml"),
        (11, 'file = "set_a_rig.toml"', 'file = "nowhere.toml"', "nowhere.toml"),
    ],
)
def test_a_bad_file_is_refused_with_its_key(number, old, new, said, tmp_path):
    path = changed(tmp_path, old, new, "set_a.toml" if number == 11 else f"fig_{number:02d}.toml")
    with pytest.raises(InputError, match=said) as caught:
        reproduce([number], folder=path.parent)
    assert str(path.parent) in str(caught.value)


def test_one_branch_alone_can_be_measured(tmp_path):
    text = changed(
        tmp_path, "branches = [1, 2, 5, 10, 100]", "branches = [1]", "fig_06.toml"
    ).read_text("utf-8")
    (tmp_path / "paper" / "fig_06.toml").write_text(
        text.replace("seeds = 6", "seeds = 1"), encoding="utf-8"
    )
    item = reproduce([6], folder=tmp_path / "paper")[0]
    assert item.numbers["branches"] == [1]
    assert not any("; from" in sentence for sentence in item.found)
    item.draw()
    item.extras["economy"][0]()


def test_a_changed_experiment_gives_another_result(tmp_path):
    changed(tmp_path, 'file = "set_a_rig.toml"', 'file = "set_a_rig.toml"\nscatter = 0.0')
    missing = reproduce([1], folder=tmp_path / "paper")[0].numbers["missing_at_return"]
    assert abs(missing["virtual rig"]) < 1e-6


def test_the_copied_files_are_complete(tmp_path):
    write_experiments(tmp_path / "paper")
    for name in ("set_a", "set_b"):
        result = [
            variant.name
            for variant in read_experiment(tmp_path / "paper" / f"{name}.toml").variants
        ]
        assert {"none", "paper", "identified"} <= set(result)


def test_an_unknown_figure_is_refused():
    with pytest.raises(InputError, match="no such figure"):
        reproduce([15])


def test_user_files_are_kept(tmp_path):
    names = {write_experiment.name for write_experiment in write_experiments(tmp_path / "mine")}
    assert names == {write_experiment.name for write_experiment in EXPERIMENTS.glob("*.toml")}
    with pytest.raises(InputError, match="--force"):
        write_experiments(tmp_path / "mine")
    write_experiments(tmp_path / "mine", force=True)
    (tmp_path / "mine" / "set_a_rig.toml").write_text("mine")
    for force in (False, True):
        with pytest.raises(InputError, match=r"that were changed: set_a_rig\.toml"):
            write_experiments(tmp_path / "mine", force=force)
    assert (tmp_path / "mine" / "set_a_rig.toml").read_text() == "mine"


def test_an_operator_is_moved_like_a_contact(setting):
    operator = setting(4).operators["f_h"]
    values = {name: operator.values[name] for name in ("kernel", "s", "f_p")}
    model = friction.preisach_contact(**values)
    turns = [3e-6, -1e-6, 2e-6]
    led, followed = bench.walk(model, turns, 1e-6, 8e-4), bench.follow(operator, turns, 8e-4)
    assert led.at_turns == pytest.approx(followed.at_turns, rel=1e-9)


# --- between which values the numbers may lie -------------------------------------------------------------------------


LEAST = {
    ("bench", "J"): 1e-12,
    ("bench", "J_m"): 0.0,
    ("bench", "acceleration"): 1e-9,
    ("bench", "torque_filter"): 1e-3,
    ("path", "turns"): -0.01,
    ("path", "speed"): 1e-9,
    ("torque", "period"): 1e-6,
    ("torque", "cycles"): 1.0,
    ("measurement", "amplitudes"): -0.01,
    ("measurement", "speed"): 1e-9,
    ("measurement", "resolution"): 0.0,
    ("measurement", "extent"): 0.0,
    ("measurement", "branches"): 1.0,
    ("measurement", "noise"): 0.0,
    ("measurement", "repeats"): 1.0,
    ("measurement", "seeds"): 1.0,
    ("transition_branches", "s"): 1e-9,
    ("transition_branches", "f_p"): 1e-12,
    ("transition_branches", "x_r"): 0.0,
    ("transition_branches", "count"): 2.0,
}
MOST = {"turns": 0.01, "amplitudes": 0.01, "resolution": 0.01, "extent": 0.01, "x_r": 0.01}
MOST |= dict.fromkeys(("cycles", "branches", "repeats", "seeds", "count"), 10_000.0)


def test_every_key_but_torques_has_a_least_value():
    assert set(LEAST) == {(section, key) for section, keys in SECTIONS.items() for key in keys} - {
        ("torque", key) for key in ("break_away", "low", "high")
    }
    assert ("schema", "name", "lead", "contact", "operator", "plant", *SECTIONS) == KEYS


PLACES = {name: (section, name) for section, name in LEAST}
ENDS = [
    *((place, value, -1.0) for place, value in LEAST.items()),
    *((PLACES[name], value, 1.0) for name, value in MOST.items()),
]
WHOLE = ("cycles", "branches", "repeats", "seeds", "count")


@pytest.mark.parametrize(
    ("place", "end", "way"), [*ENDS, *((PLACES[name], 3.0, 0.5) for name in WHOLE)]
)
def test_a_number_lies_between_its_ends_and_may_be_whole(place, end, way):
    section, name = place
    key = SECTIONS[section][name]
    assert _number(end, key, name) == end
    with pytest.raises(InputError, match="must be a whole number" if way == 0.5 else name):
        _number(end + way * (1.0 if key.is_integer else max(1e-3 * abs(end), 1e-15)), key, name)


@pytest.mark.parametrize(
    ("name", "unit"), [("break_away", "mN*m"), ("low", "mN*m"), ("high", "mN*m")]
)
def test_torques_are_those_of_the_screw(name, unit):
    assert _number(f"-3 {unit}", SECTIONS["torque"][name], name) == pytest.approx(-3e-3)


def test_lists_are_lists_with_something_in_them():
    assert _numbers({"turns": ["1 um", 2e-6], "speed": "1 um/s"}, "path")[
        "turns"
    ].tolist() == pytest.approx([1e-6, 2e-6])
    for value in ([], 3.0, "1 um"):
        with pytest.raises(InputError, match=r"path\.turns: must be a list"):
            _numbers({"turns": value}, "path")


def test_without_a_lead_torques_are_forces(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("schema = 1\n")
    setting = read_setting(path)
    assert setting.arm == pytest.approx(1.0)
    for ask, words in (
        (
            lambda: setting["path", "turns"],
            r"x\.toml: path\.turns: is missing, but this experiment needs it",
        ),
        (
            lambda: setting.contact("LuGre"),
            r"contact\.LuGre: is missing.*Write \[contact\.LuGre\] with a friction model",
        ),
        (lambda: setting.operator, r"operator: is missing.*Write \[operator\.f_h\]"),
        (lambda: setting.mass, "plant: is missing"),
    ):
        with pytest.raises(InputError, match=words):
            ask()


# --- Which experiment each figure is made from, in which order, and what it reports of its work


reproducing = import_module("bristle.apps.paper.reproduction")


@pytest.fixture
def made(monkeypatch):
    """Figures that say what they were made from, and report half of their work."""

    def contact(number):
        return lambda setting: (number, setting)

    def loop(number):
        return lambda tracked: (
            tracked.report(0.5, "simulating") or (number, tracked.source.name, tracked.allow_code)
        )

    def twelve(tracked, sound):
        for part in (tracked, sound.loop, sound.levels):
            part.report(1.0, part.source.name)
        return 12, [
            (part.source.name, part.needed, part.allow_code) for part in (sound.loop, sound.levels)
        ]

    monkeypatch.setattr(
        reproducing, "CONTACTS", {number: contact(number) for number in reproducing.CONTACTS}
    )
    monkeypatch.setattr(
        reproducing, "LOOPS", {number: loop(number) for number in reproducing.LOOPS}
    )
    monkeypatch.setattr(
        reproducing, "figure_6", lambda setting, part: part(0.25, "counting") or (6, setting)
    )
    monkeypatch.setattr(
        reproducing, "figure_7", lambda tracked, setting: (7, tracked.source.name, setting)
    )
    monkeypatch.setattr(reproducing, "figure_12", twelve)
    monkeypatch.setattr(
        reproducing, "read_setting", lambda path, allow_code: (path.name, allow_code)
    )


def test_each_figure_has_its_number_and_its_experiment(made):
    figures = reproducing.reproduce(folder=Path("experiments"))
    assert [figure[0] for figure in figures] == list(range(1, 15)) == list(FIGURES)
    by_number = {figure[0]: figure[1:] for figure in figures}
    for number in (1, 2, 3, 4, 5, 6, 8, 9, 10):
        assert by_number[number] == ((f"fig_{number:02d}.toml", False),)
    assert by_number[7] == ("set_a.toml", ("fig_07.toml", False))
    for number in (11, 13, 14):
        assert by_number[number] == ("set_a.toml", False)
    assert by_number[12] == (
        [("set_c.toml", ("none",), False), ("set_a_break_away.toml", (), False)],
    )
    assert reproducing.reproduce([6], folder=Path("experiments"), allow_code=True) == [
        (6, ("fig_06.toml", True))
    ]


def test_figures_are_reproduced_once_each_and_report_their_part_of_the_work(made):
    shares = []
    figures = reproducing.reproduce(
        [12, 6, 6, 11],
        folder=Path("experiments"),
        progress=lambda share, text: shares.append((round(share, 9), text)),
    )
    assert [figure[0] for figure in figures] == [6, 11, 12]
    third, ninth = 1.0 / 3.0, 1.0 / 9.0
    assert shares == [
        (0.0, "figure 6"),
        (pytest.approx(0.25 * third), "figure 6, counting"),
        (pytest.approx(third), "figure 11"),
        (pytest.approx(1.5 * third), "figure 11, simulating"),
        (pytest.approx(2.0 * third), "figure 12"),
        (pytest.approx(2.0 * third + ninth), "figure 12, set_a.toml"),
        (pytest.approx(2.0 * third + 2.0 * ninth), "figure 12, set_c.toml"),
        (pytest.approx(1.0), "figure 12, set_a_break_away.toml"),
    ]
