"""Compute the walks of the page anew: ``python -m tests.lab.write_walks``."""

import json
from pathlib import Path

import bristle.lab
from bristle.friction import MODELS
from bristle.lab.described import example_named
from bristle.lab.switches import all_walks

FILE = Path(bristle.lab.__file__).parent / "walks.json"

if __name__ == "__main__":
    walks = {name: all_walks(example_named(name)) for name in MODELS}
    FILE.write_text(json.dumps(walks, indent=1) + "\n", encoding="utf-8")
