"""Compute the walks of the page anew, of all models or of some: ``python -m tests.lab.write_walks [MODEL ...]``."""

import json
import sys
from pathlib import Path

import bristle.exports.page
from bristle.exports.page import described, switches
from bristle.friction import MODELS

FILE = Path(bristle.exports.page.__file__).parent / "walks.json"

if __name__ == "__main__":
    names = sys.argv[1:] or MODELS
    walks = {name: switches.all_walks(described.example_named(name)) if name in names else described.stored()[name] for name in MODELS}
    FILE.write_text(json.dumps(walks, indent=1) + "\n", encoding="utf-8")
