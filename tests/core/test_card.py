"""Results in a few lines: never more than fit on a screen, and nothing from a file is taken for markup."""

from dataclasses import dataclass

from bristle.core.tabular import Card, WithCard

MANY = Card(
    "much",
    ("Name", "Value"),
    tuple((f"row {i}", "1") for i in range(500)),
    tuple(map(str, range(500))),
)


def test_it_is_never_longer_than_a_screen():
    lines = MANY.text().splitlines()
    assert (lines[0], len(lines) <= 30, MANY.html().count("<tr>") < 30) == ("much", True, True)
    assert "and 480 more rows" in MANY.text()
    assert "and 494 more remarks" in MANY.text()


def test_columns_are_aligned():
    text = Card("t", ("Name", "Value"), (("a", "1 m"), ("longer", "2 m"))).text()
    assert text.splitlines()[1:] == ["  Name    Value", "  a       1 m", "  longer  2 m"]


def test_text_from_files_is_escaped_and_kept_in_one_line():
    card = Card("<b>", ("<i>",), (("<script>alert(1)</script>\n",),), ("a & b\x1b[31m",))
    html = card.html()
    assert "<script>" not in html
    assert "&lt;script&gt;" in html
    assert "a &amp; b" in html
    assert "\x1b" not in html + card.text()
    assert len(card.text().splitlines()) == 4


def test_a_dataclass_is_shown_as_its_card():
    @dataclass
    class Result(WithCard):
        values: list[float]

        def _card(self):
            return Card(f"{len(self.values)} numbers")

    assert repr(Result([0.0] * 1000)) == "1000 numbers"
    assert Result([0.0])._repr_html_() == "<div><strong>1 numbers</strong></div>"
