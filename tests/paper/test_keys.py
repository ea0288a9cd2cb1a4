"""Between which values the numbers of the paper's experiments may lie."""

import pytest

from bristle.core.errors import InputError
from bristle.paper.setting import KEYS, SECTIONS, _number, _numbers, read_setting

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


@pytest.mark.parametrize(("place", "least"), LEAST.items(), ids=map(".".join, LEAST))
def test_a_number_lies_at_its_least_value_or_above(place, least):
    section, name = place
    key = SECTIONS[section][name]
    assert _number(least, key, name) == least
    below = least - (1.0 if key.is_integer else max(1e-3 * abs(least), 1e-15))
    with pytest.raises(InputError, match=name):
        _number(below, key, name)


@pytest.mark.parametrize(("name", "most"), MOST.items())
def test_a_number_lies_at_its_largest_value_or_below(name, most):
    key = next(keys[name] for keys in SECTIONS.values() if name in keys)
    assert _number(most, key, name) == most
    with pytest.raises(InputError, match=name):
        _number(most + (1.0 if key.is_integer else 1e-6), key, name)


@pytest.mark.parametrize("name", ["cycles", "branches", "repeats", "seeds", "count"])
def test_a_number_of_times_is_whole(name):
    key = next(keys[name] for keys in SECTIONS.values() if name in keys)
    with pytest.raises(InputError, match="must be a whole number"):
        _number(3.5, key, name)


@pytest.mark.parametrize(("name", "unit"), [("break_away", "mN*m"), ("low", "mN*m"), ("high", "mN*m")])
def test_torques_are_those_of_the_screw(name, unit):
    assert _number(f"-3 {unit}", SECTIONS["torque"][name], name) == pytest.approx(-3e-3)


def test_lists_are_lists_with_something_in_them():
    assert _numbers({"turns": ["1 um", 2e-6], "speed": "1 um/s"}, "path")["turns"].tolist() == pytest.approx([1e-6, 2e-6])
    for value in ([], 3.0, "1 um"):
        with pytest.raises(InputError, match=r"path\.turns: must be a list"):
            _numbers({"turns": value}, "path")


def test_without_a_lead_torques_are_forces(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("schema = 1\n")
    setting = read_setting(path)
    assert setting.arm == pytest.approx(1.0)
    for ask, words in (
        (lambda: setting["path", "turns"], r"x\.toml: path\.turns: is missing, but this experiment needs it"),
        (lambda: setting.contact("LuGre"), r"contact\.LuGre: is missing.*Write \[contact\.LuGre\] with a friction model"),
        (lambda: setting.operator, r"operator: is missing.*Write \[operator\.f_h\]"),
        (lambda: setting.mass, "plant: is missing"),
    ):
        with pytest.raises(InputError, match=words):
            ask()
