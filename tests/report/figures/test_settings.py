"""Whatever matplotlib is set to, the figures are the same; whatever is drawn, matplotlib is set to what it was."""

import hashlib
import io
import json
import logging
import os
import re
import subprocess
import sys
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import matplotlib
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patheffects import withStroke
from tests.report.figures.gallery import drawn, gallery
from tests.report.figures.hostile_settings import SETTINGS

from bristle import figures
from bristle.core.cores import Abreast

ROOT = Path(__file__).parents[3]
# Between them: names at axes, a legend, a title, numbers in every form, hatches, marks.
SOME = ("preisach_stages", "margins", "errors_by_truth", "residuals")
GALLERY = """
from tests.report.figures.gallery import gallery
from bristle.report.figures import inline_svg
"""
DRAW = f"""
import hashlib, json
{GALLERY}
found, draws = {{}}, gallery()
for name in {SOME}:
    svg = inline_svg(draws[name](), name.replace("_", "-"), name)
    found[name] = hashlib.sha256(svg.encode()).hexdigest()
"""


@contextmanager
def usual():
    """Matplotlib as it is where nobody has set anything."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        yield


@pytest.fixture(scope="module")
def plain():
    """Some figures as they are usually drawn."""
    with usual():
        draws = gallery()
        return {
            name: figures.inline_svg(draws[name](), name.replace("_", "-"), name) for name in SOME
        }


@pytest.fixture
def hostile(monkeypatch):
    """Matplotlib set to everything that would show."""
    with matplotlib.rc_context():
        for line in SETTINGS.splitlines():
            key, _, value = map(str.strip, line.partition(":"))
            if key in matplotlib.rcParams and key != "backend" and value != "thirty":
                matplotlib.rcParams[key] = value
        matplotlib.rcParams["path.effects"] = [withStroke(linewidth=9)]
        yield dict(matplotlib.rcParams.copy())


@pytest.mark.slow
def test_no_setting_changes_a_figure_and_no_figure_changes_a_setting(hostile):
    result = drawn()
    with usual():
        expected = drawn()
    assert [name for name, svg in result.items() if svg != expected[name]] == []
    assert dict(matplotlib.rcParams.copy()) == hostile


def saved(figure, **how):
    out = io.BytesIO()
    figure.savefig(out, **how)
    return out.getvalue()


def shown(figure):
    """A figure as a window or a notebook shows it."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return bytes(canvas.buffer_rgba())


@pytest.mark.parametrize(
    "show",
    [partial(saved, format="svg", metadata={"Date": None}), saved, shown],
    ids=["svg", "png", "canvas"],
)
def test_a_figure_saved_or_shown_by_the_user_is_the_same(show, hostile):
    result = show(gallery()["expected"]())
    with usual():
        assert show(gallery()["expected"]()) == result


@pytest.mark.slow
def test_concurrent_threads_restore_all_settings(hostile, plain):
    names = SOME * 2
    with Abreast(4) as pool:
        draws = gallery()
        result = pool.map(
            lambda name: figures.inline_svg(draws[name](), name.replace("_", "-"), name), names
        )
        assert [name for name, svg in zip(names, result, strict=True) if svg != plain[name]] == []
    assert dict(matplotlib.rcParams.copy()) == hostile


def run(code, folder, **environment):
    """Run Python in a folder; return what it printed, and what it remarked."""
    variables = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])} | environment
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout, ended.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "environment"),
    [
        pytest.param(SETTINGS.encode(), {}, id="settings", marks=pytest.mark.slow),
        pytest.param(
            b"text.usetex = True\n<html>\n::\n\x00\n",
            {"MPLBACKEND": "module://no.such"},
            id="no settings",
        ),
        pytest.param(
            None,
            {"MPLCONFIGDIR": os.devnull, "MATPLOTLIBRC": os.curdir},
            id="folders",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_no_settings_file_or_variable_changes_a_figure_or_causes_a_warning(
    file, environment, tmp_path, plain
):
    if file is not None:
        (tmp_path / "matplotlibrc").write_bytes(file)
    after = "import os; print(os.environ.get('MPLBACKEND'))"
    message, remarks = run(f"{DRAW}\nprint(json.dumps(found))\n{after}", tmp_path, **environment)
    assert remarks == ""
    result, left = message.splitlines()
    assert left == str(environment.get("MPLBACKEND"))
    assert json.loads(result) == {
        name: hashlib.sha256(plain[name].encode()).hexdigest() for name in SOME
    }


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("file", "environment", "words"),
    [
        (b"font.family: caf\xe9\n", {}, "can't decode byte"),
        (b"", {"MPLBACKEND": "nonsense"}, "'nonsense' is not a valid value"),
        (
            b"axes.formatter.use_locale: True\n",
            {"LC_ALL": "xx_YY.nonsense"},
            "unsupported locale setting",
        ),
    ],
)
def test_settings_that_break_the_import_of_matplotlib_are_reported(
    file, environment, words, tmp_path
):
    (tmp_path / "matplotlibrc").write_bytes(file)
    code = "from bristle.core import InputError\ntry:\n    import bristle.report.figures\nexcept InputError as error:\n    print(error)"
    message, remarks = run(code, tmp_path, **environment)
    assert remarks == ""
    assert re.search(
        f"cannot be imported with the settings of this machine.*{words}.*Correct the file matplotlibrc",
        message,
        re.DOTALL,
    )


@pytest.mark.slow
def test_figures_of_the_user_follow_the_settings_file_of_the_user(tmp_path):
    (tmp_path / "matplotlibrc").write_text("font.size: 31\nlines.linewidth: 7\nbackend: pdf\n")
    message, _ = run(
        "import bristle.report.figures, logging, matplotlib, os\n"
        "rc = matplotlib.rcParams\n"
        "level = logging.getLogger('matplotlib').level\n"
        "print(rc['font.size'], rc['lines.linewidth'], rc['backend'], os.environ['MPLBACKEND'], level)",
        tmp_path,
        MPLBACKEND="svg",
    )
    assert message.split() == ["31.0", "7.0", "svg", "svg", str(logging.NOTSET)]


@pytest.mark.slow
def test_an_earlier_session_is_unchanged(tmp_path):
    message, _ = run(
        "import logging, matplotlib\n"
        "import matplotlib.pyplot as plt\n"
        "plt.rcParams.update({'text.usetex': True, 'font.size': 31, 'svg.fonttype': 'path'})\n"
        "logging.getLogger('matplotlib').setLevel(15)\n"
        "figure, canvas = plt.figure(), plt.gcf().canvas\n"
        "before = dict(matplotlib.rcParams.copy())\n"
        f"{GALLERY}\n"
        "inline_svg(gallery()['margins'](), 'a', '')\n"
        "gallery()['margins']().savefig('saved.svg')\n"
        "assert dict(matplotlib.rcParams.copy()) == before\n"
        "assert plt.get_backend() == 'template'\n"
        "assert plt.gcf() is figure and figure.canvas is canvas and plt.get_fignums() == [1]\n"
        "print(logging.getLogger('matplotlib').level)\n",
        tmp_path,
        MPLBACKEND="template",
    )
    assert message.split() == ["15"]


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_process_forked_during_drawing_can_draw_with_the_users_settings(tmp_path):
    message, _ = run(
        "import os, signal, threading, warnings, matplotlib\n"
        "from bristle.report.figures.drawing import own_settings\n"
        f"{GALLERY}\n"
        "warnings.simplefilter('ignore')\n"
        "matplotlib.rcParams['font.size'] = 31\n"
        "begun, end = threading.Event(), threading.Event()\n"
        "def work():\n"
        "    with own_settings():\n"
        "        begun.set(); end.wait(0.3)\n"
        "thread = threading.Thread(target=work); thread.start(); begun.wait()\n"
        "child = os.fork()\n"
        "if not child:\n"
        "    signal.alarm(20)\n"
        "    size = matplotlib.rcParams['font.size']\n"
        "    inline_svg(gallery()['margins'](), 'a', '')\n"
        "    os._exit(int(size))\n"
        "thread.join()\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), matplotlib.rcParams['font.size'])",
        tmp_path,
    )
    assert message.split() == ["31", "31.0"]
