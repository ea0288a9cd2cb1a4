"""The scripts of `.ci`: CI runs the lines of the README, each slow part gets its turn, and commits keep two habits."""

import importlib.machinery
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
BASH = shutil.which("bash") if os.name == "posix" else None
needs_shell = pytest.mark.skipif(not BASH or not shutil.which("git"), reason="needs bash and git")


@pytest.fixture(scope="module")
def slow():
    loader = importlib.machinery.SourceFileLoader("slow_parts", str(ROOT / ".ci" / "slow"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("slow_parts", loader))
    sys.modules["slow_parts"] = module  # its dataclass looks itself up
    loader.exec_module(module)
    yield module
    del sys.modules["slow_parts"]


def lines_of(readme):
    return subprocess.run(
        [BASH, ROOT / ".ci" / "readme", readme], capture_output=True, text=True, check=True
    ).stdout.splitlines()


@needs_shell
def test_ci_runs_the_lines_of_the_readme_letter_by_letter(tmp_path):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = lines_of(ROOT / "README.md")
    assert len(lines) == 2
    assert all(f"\n{line}\n" in text for line in lines)
    assert "pytest" in lines[1]
    changed = tmp_path / "README.md"
    changed.write_text(text.replace("pytest -n auto", "pytest -n 4 --maxfail=1"), encoding="utf-8")
    assert lines_of(changed) == [
        lines[0],
        lines[1].replace("pytest -n auto", "pytest -n 4 --maxfail=1"),
    ]
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert re.findall(r"^[^#\n]*pytest .*", script, flags=re.MULTILINE) == [
        "python -m pytest --quiet -m slow tests/architecture"
    ]


def test_each_slow_part_takes_ten_minutes_at_most_and_runs_at_night(slow):
    assert max(part.minutes for part in slow.parts()) <= 10
    nightly = (ROOT / ".github" / "workflows" / "nightly.yml").read_text(encoding="utf-8")
    assert ".ci/slow --list" in nightly


def test_slow_parts_cover_each_folder_of_tests_once(slow):
    commands = [
        part.command
        for part in slow.parts()
        if part.command.startswith("pytest") and "--share" not in part.command
    ]
    commands += [
        part.command
        for part in slow.parts()
        if " --share 1/" in part.command and part.command.startswith("pytest")
    ]
    named = [word for command in commands for word in command.split() if word.startswith("tests/")]
    assert len(named) == len(set(named))
    folders = {path for path in named if not path.endswith(".py")}
    assert not [
        path for path in folders if folders & {parent.as_posix() for parent in Path(path).parents}
    ]
    for file in (ROOT / "tests").rglob("test_*.py"):
        if "slow" in file.read_text(encoding="utf-8"):
            path = file.relative_to(ROOT)
            assert set(named) & {
                path.as_posix(),
                *(parent.as_posix() for parent in path.parents),
            }, path


def test_what_a_change_touches_comes_first_and_the_rest_takes_turns(slow):
    parts = [slow.Part(f"p{k}", "", 5.0, (f"src/{k}/",), ()) for k in range(5)]
    order = [part.name for part in slow.due(parts, ["src/3/a.py"], 0)]
    assert order == ["p3", "p0", "p1", "p2", "p4"]
    first = {slow.due(parts, [], count)[0].name for count in range(5)}
    assert first == {"p0", "p1", "p2", "p3", "p4"}
    assert [part.name for part in slow.within(parts, 11.0)] == ["p0", "p1"]
    assert not slow.within([slow.Part("p", "", 5.0, (), (), is_nightly=True)], 11.0)
    constant = slow.Part("browser", "", 5.0, (), (), is_constant=True)
    assert [part.name for part in slow.within([*parts, constant], 11.0)] == ["browser", "p0"]


def test_each_run_of_ci_has_the_browser_and_a_site_without_broken_links(slow):
    (command,) = [part.command for part in slow.parts() if part.is_constant]
    # A missing browser fails the part.
    assert {"--ci", "tests/apps/lab/test_browser.py"} < set(command.split())
    (options,) = re.findall(
        r"mkdocs.*? build (.*)", (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    )
    # Quiet, it counts no warnings.
    assert ("--strict" in options, "--quiet" in options) == (True, False)


def test_each_path_that_makes_a_part_due_exists():
    parts = tomllib.loads((ROOT / ".ci" / "parts.toml").read_text(encoding="utf-8"))
    missing = [
        path for part in parts.values() for path in part["touches"] if not (ROOT / path).exists()
    ]
    assert not missing


@needs_shell
def test_an_unknown_part_is_refused():
    ended = subprocess.run(
        [sys.executable, ROOT / ".ci" / "slow", "nonsense"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 2
    assert "nonsense" in ended.stderr


def git(folder, *arguments):
    who = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)


@needs_shell
@pytest.mark.parametrize(
    ("ceiling", "other", "subject", "fault"),
    [
        (10, "x", "core: a change", ""),
        (11, "", "core: " + 66 * "x", ""),
        (10, "x", "core: " + 67 * "x", "more than 72"),
        (11, "", "tests: a ceiling is raised alone", ""),
        (11, "x", "core: a ceiling is raised beside", "package.core.weight beside other changes"),
    ],
)
def test_growth_judges_subjects_and_raised_ceilings(tmp_path, ceiling, other, subject, fault):
    for file in (".ci/growth", "tests/architecture/ceilings.py"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / file, tmp_path / file)
    ceilings = tmp_path / "tests" / "architecture" / "ceilings.toml"
    ceilings.write_text("[package]\ncore = { weight = 10 }\n", encoding="utf-8")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "-A")
    git(tmp_path, "commit", "-q", "-m", "begin")
    ceilings.write_text(f"[package]\ncore = {{ weight = {ceiling} }}\n", encoding="utf-8")
    if other:
        (tmp_path / "module.py").write_text(other, encoding="utf-8")
    git(tmp_path, "add", "-A")
    git(tmp_path, "commit", "-q", "--allow-empty", "-m", subject)
    judged = subprocess.run(
        [BASH, tmp_path / ".ci" / "growth", "HEAD~1"], check=False, capture_output=True, text=True
    )
    assert judged.returncode == (1 if fault else 0), judged.stderr
    assert fault in judged.stderr


@pytest.mark.parametrize("tiny", [2e-15, np.float32(2e-15), -2e-15, 2e-15j])
def test_a_tiny_expected_value_is_met_by_its_share_and_zero_by_rounding(tiny):
    assert 1.1 * tiny == pytest.approx(tiny, rel=0.15)
    assert 1.2 * tiny != pytest.approx(tiny, rel=0.15)
    assert [tiny, 0.0] != pytest.approx([0.0, 0.0], abs=1e-18)
    assert [1.2 * tiny] != pytest.approx([tiny])
    assert pytest.approx(0.0) == 1e-13
