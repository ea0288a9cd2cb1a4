"""Former places of modules: each is the same module, with one warning for each package, until release 0.4."""

import importlib
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import bristle as br
from bristle.core.aliases import PLACES, present_name

LINES = Path(__file__).with_name("former_imports.txt").read_text(encoding="utf-8").splitlines()
DELETED = {"bristle.bench": "python -m benchmarks board"}
RUN = """
import sys
import warnings
warnings.simplefilter("ignore")
for line in sys.stdin:
    try:
        exec(line, {})
        print("ok")
    except ImportError as error:
        print(str(error))
"""


@pytest.fixture(scope="module")
def outcomes():
    """What the import lines of the pages and the examples of release 0.3 give in a new process."""
    text = "\n".join(LINES)
    ended = subprocess.run(
        [sys.executable, "-c", RUN], input=text, capture_output=True, text=True, check=True
    )
    return dict(zip(LINES, ended.stdout.splitlines(), strict=True))


def test_the_table_stays_short():
    assert len(PLACES) <= 40


@pytest.mark.filterwarnings("ignore:bristle:DeprecationWarning")
@pytest.mark.parametrize("former", [name for name in PLACES if name != "exports"])
def test_a_former_module_is_the_present_one(former):
    place = f"bristle.{former}"
    assert importlib.import_module(place) is importlib.import_module(present_name(place))
    assert find_spec(present_name(place)).name == importlib.import_module(place).__spec__.name


def test_a_module_of_a_moved_package_is_loaded_once():
    code = """
import bristle.study
import bristle.study.many_runs
import bristle.apps.study.many_runs
print(bristle.study.many_runs is bristle.apps.study.many_runs)
"""
    command = [sys.executable, "-W", "ignore", "-c", code]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ended.stdout == "True\n"


@pytest.mark.filterwarnings("ignore:bristle:DeprecationWarning")
def test_a_target_is_found_where_it_was():
    import bristle.apps.targets.st

    assert importlib.import_module("bristle.exports.st") is bristle.apps.targets.st


@pytest.mark.filterwarnings("ignore:bristle:DeprecationWarning")
def test_a_former_submodule_does_not_replace_the_model_of_its_name():
    importlib.import_module("bristle.friction.lugre")
    importlib.import_module("bristle.friction.dahl")
    assert br.friction.lugre(F_C=1.0, F_S=1.0, v_S=1.0, sigma_0=1.0).name == "lugre"
    assert callable(br.friction.dahl)


def test_a_former_submodule_does_not_replace_a_function_of_its_package():
    code = """
import bristle.loop.design, bristle.paper.reproduce, bristle as br
from bristle.apps import design, paper
print(br.design.__name__, design.design.__name__, paper.reproduce.__name__)
"""
    command = [sys.executable, "-W", "ignore", "-c", code]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ended.stdout.split() == ["design", "design", "reproduce"]


@pytest.mark.parametrize("name", ["nonsense", "friction.nonsense", "exports.nonsense"])
def test_a_name_that_never_was_has_the_error_of_python(name):
    with pytest.raises(
        ModuleNotFoundError, match=r"^No module named 'bristle\.\w+(\.\w+)?(\.nonsense)?'$"
    ):
        importlib.import_module(f"bristle.{name}")


def test_one_warning_names_the_present_place_at_the_line_of_the_import(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(
        "import bristle.friction\nimport bristle.friction.slots\nfrom bristle.friction import find\n"
        "import bristle.study\nimport bristle.study.many_runs\n"
    )
    ended = subprocess.run(
        [sys.executable, "-W", "always", str(script)], capture_output=True, text=True, check=True
    )
    warned = [line for line in ended.stderr.splitlines() if "DeprecationWarning" in line]
    assert [line.split(" ")[0] for line in warned] == [f"{script}:1:", f"{script}:4:"]
    assert "bristle.friction is now bristle.models.friction" in warned[0]
    assert "bristle.study is now bristle.apps.study" in warned[1]


@pytest.mark.parametrize("module", ["controllers", "plants"])
def test_a_library_that_a_present_module_misses_is_the_error(module):
    code = f"import sys; sys.modules['numpy'] = None; import bristle.{module}"
    command = [sys.executable, "-W", "ignore", "-c", code]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.stderr.splitlines()[-1].startswith("ModuleNotFoundError: import of numpy")


@pytest.mark.parametrize("line", LINES)
def test_an_import_of_a_page_of_the_last_release_works_or_names_its_successor(line, outcomes):
    advice = next((advice for name, advice in DELETED.items() if name in line), "")
    if advice:
        assert advice in outcomes[line]
    else:
        assert outcomes[line] == "ok"
