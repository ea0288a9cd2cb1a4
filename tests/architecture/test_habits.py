"""The scripts of `.ci`: each part of the slow checks runs every night, and growth of the package is explained."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
BASH = shutil.which("bash") if os.name == "posix" else None
pytestmark = pytest.mark.skipif(not BASH or not shutil.which("git"), reason="needs bash and git")


def test_every_slow_part_runs_at_night(tmp_path):
    environment = os.environ | {"BRISTLE_SLOW": str(tmp_path)}
    listed = subprocess.run([BASH, ROOT / ".ci" / "slow", "--list"], env=environment, capture_output=True, text=True, check=True).stdout
    parts = {line.split()[0]: int(line.split()[1]) for line in listed.splitlines()}
    nightly = (ROOT / ".github" / "workflows" / "nightly.yml").read_text(encoding="utf-8")
    assert sorted(parts) == sorted(re.search(r"part:\n((?: +- .*\n)+)", nightly)[1].replace("- ", " ").split())
    assert max(parts.values()) <= 60
    unknown = subprocess.run([BASH, ROOT / ".ci" / "slow", "nonsense"], check=False, env=environment, capture_output=True, text=True)
    assert unknown.returncode == 2
    assert "nonsense" in unknown.stderr


@pytest.fixture
def repository(tmp_path):
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci" / "growth", tmp_path / ".ci")
    git(tmp_path, "init", "-q")
    commit(tmp_path, 10, "core: begin")
    return tmp_path


def git(folder, *arguments):
    who = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)


def commit(folder, lines, *paragraphs):
    (folder / "src").mkdir(exist_ok=True)
    (folder / "src" / "module.py").write_text("x = 1\n" * lines)
    git(folder, "add", "-A")
    git(folder, "commit", "-q", *(part for text in paragraphs for part in ("-m", text)))


@pytest.mark.parametrize(
    ("lines", "paragraphs", "fault"),
    [
        (310, ("core: as much as is free",), ""),
        (311, ("core: more than is free",), "grows by 301 lines"),
        (311, ("core: more, explained", "Removes: the second reader"), ""),
        (20, ("core: " + 67 * "x",), "more than 72"),
    ],
)
def test_growth_of_the_package_requires_an_offset(repository, lines, paragraphs, fault):
    commit(repository, lines, *paragraphs)
    judged = subprocess.run([BASH, repository / ".ci" / "growth", "HEAD~1"], check=False, capture_output=True, text=True)
    assert judged.returncode == (1 if fault else 0)
    assert fault in judged.stderr


@pytest.mark.parametrize("tiny", [2e-15, np.float32(2e-15), -2e-15, 2e-15j])
def test_a_tiny_expected_value_is_met_by_its_share_and_zero_by_rounding(tiny):
    assert 1.1 * tiny == pytest.approx(tiny, rel=0.15)
    assert 1.2 * tiny != pytest.approx(tiny, rel=0.15)
    assert [tiny, 0.0] != pytest.approx([0.0, 0.0], abs=1e-18)
    assert [1.2 * tiny] != pytest.approx([tiny])
    assert pytest.approx(0.0) == 1e-13
