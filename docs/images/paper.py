"""Draw pictures of the source paper, from the report of ``bristle paper``: ``python docs/images/paper.py``."""

from pathlib import Path

from bristle.apps.paper import reproduce

first, sixth = reproduce([1, 6])
economy, _, _ = sixth.extras["economy"]
for name, draw in (("paper-return", first.draw), ("paper-economy", economy)):
    draw().savefig(
        Path(__file__).with_name(f"{name}.svg"), facecolor="white", metadata={"Date": None}
    )
