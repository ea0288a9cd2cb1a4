"""Draw the pictures of the how-to pages from their commands: ``python docs/images/how_to.py [NAME...]``; all of them take minutes."""

import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle
from PIL import Image

import bristle as br
from bristle.cli.main import main
from bristle.engine.contact import steady_force
from bristle.report.figures import style
from bristle.report.figures.drawing import own_settings

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
HOW_TO = ROOT / "docs" / "how-to"
EXAMPLES = ROOT / "examples"
COLOURS = 64  # enough for lines and text


def ran(*words: str, figure: str) -> Path:
    """Run a command that writes its figures; return the file of one of them."""
    if code := main([*words, "--out", "out", "--format", "png"]):
        raise SystemExit(f"bristle {' '.join(words)} ended with {code}")
    return Path("out/figures") / f"{figure}.png"


def block_of(page: str, info: str) -> Path:
    """Write the first block of a kind in a page into a file."""
    file = Path("block.toml")
    text = (HOW_TO / page).read_text(encoding="utf-8")
    file.write_text(
        re.search(rf"```{info}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)[1], encoding="utf-8"
    )
    return file


def demo() -> tuple[str, ...]:
    """Run the demonstration; return the words for its log."""
    main(["demo"])
    return "bristle-demo/log.csv", "--axis", "bristle-demo/axis.toml"


def saved(figure) -> Path:
    """Save a figure as the commands do."""
    figure.savefig("own.png", dpi=300, facecolor="white")
    return Path("own.png")


def experiment() -> Path:
    """Draw the worst reversal of the example of the experiment file."""
    return ran("run", str(block_of("experiment-file.md", "toml experiment")), figure="gain")


def motion() -> Path:
    """Draw the motion for the axis of its page."""
    return ran("excite", str(block_of("design-an-experiment.md", "toml axis")), figure="motion")


def study() -> Path:
    """Draw the spread of the example of 600 runs."""
    return ran("study", str(EXAMPLES / "study" / "study.toml"), figure="spread")


def design() -> Path:
    """Draw margins and poles of the loop of the source paper."""
    return ran(
        "design",
        str(ROOT / "src/bristle/apps/paper/experiments/set_a.toml"),
        "--variant",
        "paper",
        figure="margins",
    )


def own_figure() -> Path:
    """Draw the figure of the example, from the log of the demonstration."""
    return ran(
        "identify",
        *demo(),
        "--draws",
        "0",
        "--figure",
        str(EXAMPLES / "own_figure.py"),
        figure="residual_over_position",
    )


def export() -> Path:
    """Draw the loop of the demonstration, with and without friction compensation."""
    demo()
    return ran("run", "bristle-demo/experiment.toml", figure="gain")


def compare() -> Path:
    """Draw the comparison of the example of its page."""
    session = re.search(
        r"```python\n(.*?)^```",
        (HOW_TO / "did-it-help.md").read_text(encoding="utf-8"),
        re.DOTALL | re.MULTILINE,
    )[1]
    lines = [line[4:] for line in session.splitlines() if line.startswith((">>> ", "... "))]
    names: dict = {}
    exec("\n".join(lines), names)
    return saved(names["found"].plot())


@own_settings()
def quadratic_drag() -> Path:
    """Draw friction over velocity of the example of a model."""
    model = br.load_code(EXAMPLES / "quadratic_drag.py")(F_C="20 N", F_q="125 N*s^2/m^2")
    speed = np.concatenate([np.linspace(-0.5, -0.0, 100), np.linspace(0.0, 0.5, 100)])
    figure, ((axes,),) = style.panels(2.4)
    axes.plot(1e3 * speed, [steady_force(model, v) for v in speed], **style.PREDICTED)
    axes.set_xlabel("Velocity [mm/s]")
    axes.set_ylabel("Friction force [N]")
    return saved(figure)


PARTS = (
    (0.0, 1.6, "motor", '[effort]\nconstant, limit\n[encoder] side = "motor"'),
    (2.3, 1.4, "gear", "[transmission]\ngear_ratio"),
    (4.4, 2.2, "screw", "[transmission]\nlead"),
    (7.3, 1.9, "table", '[plant] mass\n[limits] stroke\n[encoder] side = "load"'),
)


@own_settings()
def axis() -> Path:
    """Draw the parts of an axis, with their keys in the axis file."""
    figure, ((axes,),) = style.panels(1.6)
    axes.set_axis_off()
    axes.set(xlim=(-0.6, 9.8), ylim=(-1.7, 0.7))
    axes.plot([0.0, 7.3], [0.0, 0.0], color="0.4", linewidth=2.5, zorder=0)
    for left, width, name, keys in PARTS:
        axes.add_patch(Rectangle((left, -0.5), width, 1.0, facecolor="0.92", edgecolor="0.2"))
        axes.text(left + width / 2, 0.0, name, ha="center", va="center")
        axes.text(
            left + width / 2, -0.7, keys, ha="center", va="top", family="monospace", fontsize=8
        )
    return saved(figure)


PICTURES = {
    "experiment": experiment,
    "motion": motion,
    "study": study,
    "design": design,
    "own-figure": own_figure,
    "export": export,
    "compare": compare,
    "quadratic-drag": quadratic_drag,
    "axis": axis,
}

for name in sys.argv[1:] or PICTURES:
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        picture = Image.open(PICTURES[name]()).convert("RGB")
        picture = picture.resize(
            (1080, round(picture.height * 1080 / picture.width)), Image.Resampling.LANCZOS
        )
        picture.quantize(COLOURS).save(HERE / f"{name}.png", optimize=True)
        os.chdir(HERE)
