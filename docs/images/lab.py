"""Take the picture of the lab in Chromium without a window: ``python docs/images/lab.py``."""

import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from bristle.apps.lab import lab_page

SHOWN = "model=lugre&with=preisach_lugre&path=minor"
COLOURS = 64  # enough for lines and text

with tempfile.TemporaryDirectory() as folder:
    page = Path(folder) / "lab.html"
    page.write_text(lab_page(), encoding="utf-8")
    target = Path(__file__).with_suffix(".png")
    subprocess.run(
        [
            "chromium",
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            f"--user-data-dir={folder}/profile",
            "--hide-scrollbars",
            "--force-prefers-reduced-motion",
            "--virtual-time-budget=15000",
            "--window-size=1366,860",
            f"--screenshot={target}",
            f"{page.as_uri()}#{SHOWN}",
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    Image.open(target).convert("RGB").quantize(COLOURS).save(target, optimize=True)
