"""The printed report of a browser."""

import re
import shutil
import subprocess

import pytest
from tests.report.test_pages import identification_page

MOST_PAGES = 8  # of the identification of a loop, with all of its tabs


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_report_of_a_loop_prints_on_eight_pages(stage, tmp_path):
    (tmp_path / "report.html").write_text(identification_page(stage), encoding="utf-8")
    subprocess.run(
        [
            "chromium",
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={tmp_path / 'profile'}",
            "--no-pdf-header-footer",
            f"--print-to-pdf={tmp_path / 'report.pdf'}",
            (tmp_path / "report.html").as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    assert 1 <= len(re.findall(rb"/Type\s*/Page[^s]", (tmp_path / "report.pdf").read_bytes())) <= MOST_PAGES
