"""Compute the walks of the page anew, of all models or of some: ``python -m tests.apps.lab.write_walks [MODEL ...]``."""

import json
import sys
from pathlib import Path

import bristle.apps.targets.page
from bristle.apps.targets.page import described, switches
from bristle.models.friction import MODELS

FILE = Path(bristle.apps.targets.page.__file__).parent / "walks.json"

if __name__ == "__main__":
    names = sys.argv[1:] or MODELS
    walks = {
        name: switches.all_walks(described.example_named(name))
        if name in names
        else described.stored()[name]
        for name in MODELS
    }
    FILE.write_text(json.dumps(walks, indent=1) + "\n", encoding="utf-8")
