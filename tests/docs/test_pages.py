"""What the pages say is so: links lead somewhere, commands exist, code and files in them work."""

import doctest
import re
import shlex
import tomllib
from pathlib import Path

import pytest
import typer
from tests.cli.conftest import EXPERIMENT
from tests.docs.conftest import PAGES, ROOT, blocks

from bristle.apps.arm.robot import read_robot
from bristle.apps.study import read_study_file
from bristle.apps.study.values import fitted_at
from bristle.cli.application import application
from bristle.cli.main import main
from bristle.core import Content
from bristle.core.dimensions import NAMES
from bristle.core.errors import InputError, InputWarning
from bristle.files.axis import axis_from
from bristle.files.curves import read_curve_columns
from bristle.files.experiment import KEYS, experiment_from, merged, planned_in, with_models
from bristle.files.joints import joints_in
from bristle.files.model import friction_from
from bristle.files.schema import AxisFile, Strict
from bristle.files.sources import Sources
from bristle.files.variant import FEEDFORWARD, LEARNING, RUN, SECTIONS
from bristle.identification import Determined

COMMANDS = typer.main.get_command(application()).commands
LEAST_AXIS = {
    "schema": 1,
    "kind": "translational",
    "columns": {"position": {"column": "q", "unit": "mm"}, "effort": {"column": "u", "unit": "N"}},
}


def each(*infos):
    result = blocks(*infos)
    return pytest.mark.parametrize("block", result, ids=[item.name for item in result])


def page_ids(page):
    return str(page.relative_to(ROOT))


def test_the_readme_sets_up_with_two_commands():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert "pip install . && bristle demo" in lines
    assert 'pip install ".[test]" && pytest -n auto' in lines


def test_the_readme_and_the_glossary_stay_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= 900
    glossary = (ROOT / "docs/reference/glossary.md").read_text(encoding="utf-8")
    assert len(re.findall(r"^\| (?!Term|---)", glossary, flags=re.MULTILINE)) <= 60


@pytest.mark.parametrize("page", PAGES, ids=page_ids)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if target.startswith("https://"):
            continue
        file, _, anchor = target.partition("#")
        present = (page.parent / file).resolve() if file else page
        assert present.exists(), target
        if anchor:
            assert anchor in anchors_of(present), target


def anchors_of(page):
    """The anchors that the usual viewers make from headings."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), flags=re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=page_ids)
def test_pages_have_no_data_of_the_machine(page):
    text = page.read_text()
    assert not re.search(r"(^|[\s\"'(`])/(home|root|work|tmp|usr|opt|Users)/", text)
    for path in re.findall(r"(?:\.\./)+[\w./-]*", text):
        assert (page.parent / path).resolve().is_relative_to(ROOT), (
            f"{path} leads out of the project"
        )


def test_the_map_reaches_every_page():
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached or page.suffix != ".md":
            continue
        reached.add(page)
        links = re.findall(r"\]\(([^)\s#]+)", page.read_text())
        waiting += [
            (page.parent / link).resolve() for link in links if not link.startswith("https://")
        ]
    assert [page_ids(page) for page in PAGES if page not in reached] == []


# --- code -------------------------------------------------------------------------------------------------------

WITH_PYTHON = sorted({item.page for item in blocks("python")})


def session_of(page):
    text = "\n".join(block.text for block in blocks("python") if block.page == page)
    return doctest.DocTestParser().get_doctest(text, {}, page.name, str(page), 0)


@each("python")
def test_python_in_pages_is_a_session_whose_output_is_checked(block):
    assert block.text.startswith(">>>")
    assert all(
        compile(example.source, block.name, "single") for example in session_of(block.page).examples
    )


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_PYTHON, ids=page_ids)
def test_python_in_pages_prints_the_stated_output(page, at_the_reader, results):
    session = session_of(page)
    report = []
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(session, out=report.append)
    assert runner.failures == 0, "".join(report)
    assert runner.tries > 0


# --- files ------------------------------------------------------------------------------------------------------


def positions_of(tables):
    return [axis_from(table).columns["position"].name for table in tables]


READ = {
    "toml axis": lambda text: positions_of([tomllib.loads(text)]) != [""],
    "toml axis-part": lambda text: (
        positions_of([merged(LEAST_AXIS, tomllib.loads(text))])
        == [tomllib.loads(text)["columns"]["position"]["column"]]
    ),
    "toml joints": lambda text: (
        positions_of(joints_in(Content(Path("joints.toml"), text.encode())).values())
        == ["q1", "q2"]
    ),
    "toml loop": lambda text: (
        tomllib.loads(text).items()
        <= tomllib.loads((ROOT / "examples/own_loop/rig.toml").read_text()).items()
    ),
}


@each(*READ)
def test_files_in_pages_are_read(block):
    assert READ[block.info](block.text)


@each("toml robot")
def test_robots_in_pages_are_read(block):
    pytest.importorskip("pinocchio", reason="the dynamics of an arm need pip install bristle[arm]")
    assert read_robot(Content(Path("robot.toml"), block.text.encode())).names == ("A1", "A2")


@each("toml hysteresis")
def test_files_of_curves_in_pages_are_read(block, tmp_path):
    (tmp_path / "axis.toml").write_text(block.text)
    assert read_curve_columns(tmp_path / "axis.toml").curves.start == "saturated"


@each("toml study")
def test_studies_in_pages_are_read(block, at_the_reader):
    (at_the_reader / "experiment.toml").write_text(EXPERIMENT)
    (at_the_reader / "study.toml").write_text(block.text)
    study = read_study_file(at_the_reader / "study.toml")
    assert study.count == 4000
    assert list(study.units) == [
        *tomllib.loads(block.text)["vary"],
        *tomllib.loads(block.text)["grid"],
    ]


@pytest.mark.slow
@each("toml study-part")
def test_draws_of_a_fit_in_pages_are_found(block, at_the_reader, results):
    for place, table in tomllib.loads(block.text)["vary"].items():
        assert {"F_C_pos", "F_C_neg"} <= fitted_at(table, at_the_reader, place).draws.keys()


@each("toml experiment")
def test_experiments_in_pages_are_read(block, at_the_reader):
    table = tomllib.loads(block.text.replace("results/model.toml", "model.toml"))
    experiment = experiment_from(table, at_the_reader / "experiment.toml", Sources(at_the_reader))
    assert len(experiment.variants) == len(table["compare"])


@each("toml experiment-part")
def test_identified_models_of_experiments_in_pages_are_planned(block, at_the_reader):
    whole = next(item for item in blocks("toml experiment") if item.page == block.page)
    part = tomllib.loads(block.text)
    read = (
        merged(tomllib.loads(whole.text), part),
        at_the_reader / "experiment.toml",
        Sources(at_the_reader),
    )
    assert planned_in(*read).keys() == part["identify"].keys()
    with pytest.raises(InputError, match=r"is not identified yet\. Run the experiment once"):
        with_models(*read)


@each("toml friction")
def test_friction_tables_in_pages_are_read(block, at_the_reader):
    table = tomllib.loads(block.text)["friction"]
    with pytest.warns(InputWarning, match="is run"):
        result = friction_from(
            table, kind="translational", folder=at_the_reader, path="friction", allow_code=True
        )
    assert result.name == table.get("file", table.get("model")).replace(".py", "")


def test_no_block_goes_unchecked():
    checked = (
        "toml axis",
        "toml axis-part",
        "toml contact",
        "toml hysteresis",
        "toml joints",
        "toml robot",
        "toml experiment",
        "toml friction",
        "toml experiment-part",
        "toml loop",
        "toml study",
        "toml study-part",
        "python",
        "py",  # tests/apps/targets/test_jax.py
        "sh",
        "text",
    )
    every = sum(page.read_text().count("\n```") for page in PAGES)
    assert len(blocks(*checked)) == every / 2


def keys_of(schema, prefix=""):
    for name, field in schema.model_fields.items():
        inner = next(
            (
                item
                for item in (field.annotation, *getattr(field.annotation, "__args__", ()))
                if is_table(item)
            ),
            None,
        )
        yield from keys_of(inner) if inner else [field.alias or name]


def is_table(annotation):
    return isinstance(annotation, type) and issubclass(annotation, Strict)


def test_the_axis_page_lists_every_key():
    page = (ROOT / "docs/how-to/axis-file.md").read_text()
    keys = set(keys_of(AxisFile))
    assert {"presliding", "gear_ratio", "cutoff", "schema"} <= keys
    assert [key for key in sorted(keys) if not re.search(rf"`[^`]*\b{key}\b[^`]*`", page)] == []


def test_the_page_of_models_lists_every_quantity_with_its_units():
    page = (ROOT / "docs/how-to/your-own-model.md").read_text()
    rows = {
        name: f"| `{name}` | {entry.translational} | {entry.rotational} |"
        for name, entry in NAMES.items()
    }
    rows |= {
        name: f"{rows[name]} `{entry.product}` |" for name, entry in NAMES.items() if entry.product
    }
    assert [name for name, row in rows.items() if row not in page] == []


def test_the_experiment_page_lists_every_key():
    page = (ROOT / "docs/how-to/experiment-file.md").read_text()
    keys = {*KEYS, *SECTIONS, *RUN, *FEEDFORWARD, *LEARNING} - {"kind"}
    assert [key for key in sorted(keys) if not re.search(rf"\b{key}\b", page)] == []


# --- commands ---------------------------------------------------------------------------------------------------


@each("sh")
def test_commands_in_pages_exist(block):
    for line in block.text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if "bristle" not in words or words[0] != "bristle" or words[1] not in COMMANDS:
            assert not line.startswith("bristle"), line
            continue
        options = {option for param in COMMANDS[words[1]].params for option in param.opts}
        assert [word for word in words if word.startswith("--") and word not in options] == [], line


MAIN_JOB = [
    line
    for block in blocks("sh")
    if block.page == ROOT / "docs/how-to/your-own-log.md"
    for line in block.text.splitlines()
]


def test_the_main_job_has_five_steps():
    assert [line.split()[:2] for line in MAIN_JOB] == [
        ["bristle", name] for name in ("log", "log", "identify", "check", "predict")
    ]


@pytest.mark.slow
def test_the_steps_of_the_main_job_work_as_written(
    at_the_reader, results, tmp_path, capsys, monkeypatch
):
    # Ten more identifications
    monkeypatch.setattr(Determined, "by_simulated_logs", lambda *_, **__: ())
    for line in MAIN_JOB:
        # The results of the folder are there already; a second copy goes elsewhere. Two models stand for all of them.
        stand_ins = {"results": str(tmp_path / "again"), "all": "coulomb_viscous,viscous"}
        words = [stand_ins.get(word, word) for word in shlex.split(line)[1:]]
        assert main(words) == 0, capsys.readouterr().err
