"""Tables on a terminal: whatever its width, nothing is cut off."""

import pytest

from bristle.cli import terminal
from bristle.report.table import Table

HEADS = ("Model", "Parameters", "Held-out error [%]", "Spread over blocks [%]", "Error of the fit [%]", "Not identified")
ROWS = (
    ("coulomb_viscous+asymmetry", "5", "3.13", "± 0.18", "3.11", "gap, sigma_2_pos, sigma_2_neg"),
    ("coulomb_viscous", "4", "4.13", "± 0.20", "4.08", "–"),
)


@pytest.mark.parametrize("width", [40, 72, 83, 84, 85, 90, 100, 120, 160])
def test_no_word_is_cut_off(width, monkeypatch, capsys):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", width)
    terminal.show_table(Table("Models compared", HEADS, ROWS))
    lines = capsys.readouterr().out.splitlines()
    words = {word for line in lines for word in line.replace(":", "").split()}
    # Where there is no room for columns, each row is told under its own name.
    assert {word for text in (*HEADS[1:], *(cell for row in ROWS for cell in row)) for word in text.split()} <= words
    if any("───" in line for line in lines):
        assert max(len(line.rstrip()) for line in lines) <= width


@pytest.mark.parametrize(("letters", "has_columns"), [(10, True), (11, False)])
def test_a_table_without_room_for_its_words_is_written_row_by_row(monkeypatch, capsys, letters, has_columns):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", 30)
    word = letters * "x"
    # Two blanks and a line beside each of three columns leave 20 letters, of which Model and Value take ten.
    terminal.show_table(Table("Two models", ("Model", "Value", "Note", "Empty"), [("a", "1.5", "", ""), ("b", "2", word, "")]))
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines() if line.strip()]
    if has_columns:
        assert [line.split() for line in (lines[0], lines[1], *lines[-2:])] == [
            ["Two", "models"],
            ["Model", "Value", "Note"],
            ["a", "1.5"],
            ["b", "2", word],
        ]
    else:
        assert lines == ["Two models", "a", "  Value: 1.5", "b", "  Value: 2", f"  Note: {word}"]


@pytest.mark.parametrize(("width", "used"), [(99, 99), (100, 100), (101, 100), (160, 100)])
def test_equations_are_laid_out_in_lines_of_100_letters_at_most(monkeypatch, capsys, width, used):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", width)
    terminal.say_laid_out(lambda columns: f"{columns}: {120 * 'x'}")
    assert capsys.readouterr().out == f"{used}: {120 * 'x'}\n\n"


def test_letters_missing_in_an_encoding_are_spelt_out():
    text, end = terminal._plain(UnicodeEncodeError("ascii", "5 µm", 2, 3, "no such letter"))
    assert (text.isascii(), len(text) > 0, end) == (True, True, 3)
    with pytest.raises(UnicodeDecodeError):
        terminal._plain(UnicodeDecodeError("ascii", b"\xff", 0, 1, "no letter"))
