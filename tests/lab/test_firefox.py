"""The page in Firefox, where there is one: the bits of Python, the loop in its worker, and no complaint."""

import shutil

import pytest
from tests.lab.firefox import firefox
from tests.lab.proved import GIVEN, blocks_with_given

from bristle.exports.page.described import example_named
from bristle.lab import lab_page

pytestmark = [pytest.mark.slow, pytest.mark.skipif(shutil.which("firefox-esr") is None, reason="needs firefox-esr")]
WAIT = """
return (async () => {
  const ready = () => %s;
  for (let k = 0; k < 600 && !ready(); k++) await new Promise((done) => setTimeout(done, 50));
  return ready();
})();
"""


def test_firefox_computes_the_bits_of_python_without_complaints(tmp_path):
    page = tmp_path / "lab.html"
    page.write_text(lab_page(example_named(GIVEN), source="model.toml"), encoding="utf-8")
    with firefox(tmp_path / "profile") as tab:
        tab.call("WebDriver:Navigate", url=f"{page.as_uri()}#selftest")
        assert tab.run(WAIT % "/differ/.test(document.getElementById('selftest').textContent)")
        message = tab.run("return document.getElementById('selftest').textContent;")
        assert message == f"0 of {blocks_with_given()} blocks differ"
        tab.run("document.getElementById('tab-track').click();")
        assert tab.run(WAIT % "/Peak-to-peak/.test(document.getElementById('track-reading').textContent)")
        tab.run("document.getElementById('tab-checks').click();")
        assert tab.run(WAIT % "document.getElementById('verdicts').children.length") == 3
        assert tab.complaints("lab.html") == []
        assert tab.complaints("Content-Security-Policy") == []
