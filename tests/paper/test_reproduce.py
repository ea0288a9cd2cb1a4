"""Which experiment each figure is made from, in which order, and what it reports of its work."""

from importlib import import_module
from pathlib import Path

import pytest

from bristle.paper.reproduce import FIGURES

reproduce = import_module("bristle.paper.reproduce")
FOLDER = Path("experiments")


@pytest.fixture
def made(monkeypatch):
    """Figures that say what they were made from, and report half of their work."""

    def contact(number):
        return lambda setting: (number, setting)

    def loop(number):
        return lambda tracked: tracked.report(0.5, "simulating") or (number, tracked.source.name, tracked.allow_code)

    def twelve(tracked, sound):
        for part in (tracked, sound.loop, sound.levels):
            part.report(1.0, part.source.name)
        return 12, [(part.source.name, part.needed, part.allow_code) for part in (sound.loop, sound.levels)]

    monkeypatch.setattr(reproduce, "CONTACTS", {number: contact(number) for number in reproduce.CONTACTS})
    monkeypatch.setattr(reproduce, "LOOPS", {number: loop(number) for number in reproduce.LOOPS})
    monkeypatch.setattr(reproduce, "figure_6", lambda setting, part: part(0.25, "counting") or (6, setting))
    monkeypatch.setattr(reproduce, "figure_7", lambda tracked, setting: (7, tracked.source.name, setting))
    monkeypatch.setattr(reproduce, "figure_12", twelve)
    monkeypatch.setattr(reproduce, "read_setting", lambda path, allow_code: (path.name, allow_code))


def test_each_figure_has_its_number_and_its_experiment(made):
    figures = reproduce.reproduce(folder=FOLDER)
    assert [figure[0] for figure in figures] == list(range(1, 15)) == list(FIGURES)
    by_number = {figure[0]: figure[1:] for figure in figures}
    for number in (1, 2, 3, 4, 5, 6, 8, 9, 10):
        assert by_number[number] == ((f"fig_{number:02d}.toml", False),)
    assert by_number[7] == ("set_a.toml", ("fig_07.toml", False))
    for number in (11, 13, 14):
        assert by_number[number] == ("set_a.toml", False)
    assert by_number[12] == ([("set_c.toml", ("none",), False), ("set_a_break_away.toml", (), False)],)
    assert reproduce.reproduce([6], folder=FOLDER, allow_code=True) == [(6, ("fig_06.toml", True))]


def test_figures_are_reproduced_once_each_and_report_their_part_of_the_work(made):
    shares = []
    figures = reproduce.reproduce([12, 6, 6, 11], folder=FOLDER, progress=lambda share, text: shares.append((round(share, 9), text)))
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
