"""Parse a page: its tags, identifiers and text."""

from html.parser import HTMLParser

from bristle.report.assets import joined

VOID = {"meta", "br", "link", "img", "hr", "input", "col", "wbr"}


class Page(HTMLParser):
    """The contents of a page; unbalanced tags are in `unbalanced`."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open, self.unbalanced, self.tags, self.text, self.cells = [], [], [], [], []
        self.in_word = False
        self.feed(text)
        self.close()
        self.unbalanced += self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.in_word = tag == "wbr"
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.unbalanced.append(tag)

    def handle_data(self, data):
        if not {"style", "script"} & set(self.open):
            self.text.append(data)
        if self.open and self.open[-1] in ("td", "th"):
            self.cells.append(self.cells.pop() + data if self.in_word else data)
        self.in_word = False

    def named(self, tag):
        return [attrs for name, attrs in self.tags if name == tag]

    @property
    def words(self) -> str:
        return " ".join("".join(self.text).split())


def plain(lines):
    """Lines without spaces that do not break."""
    return [line.replace("\u00a0", " ") for line in lines]


PLOTS = "<script>" + joined(("plots.js",), "bristle.report") + "</script>"


def seen_by(monkeypatch, module):
    """The facts, the first page and the sections that a module makes pages of; no page is written."""
    seen = {}

    def report_page(kind, facts, front, sections, **options):
        seen.update(facts, front=front, sections=sections)
        return ""

    monkeypatch.setattr(module, "report_page", report_page)
    return seen


def without_plots(text):
    """A page without the script of its plots, which every report has once."""
    assert text.count(PLOTS) == 1
    return text.replace(PLOTS, "")
