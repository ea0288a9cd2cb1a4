"""Build wheel and sdist, check their contents, and run `bristle demo` from the wheel in new environments.

    python packaging/check.py [--out dist] [--licences] [--quick]

It needs ``build`` and ``twine``. With ``uv``, it also tests ``uv tool run``.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parent.parent
CARRIED = {
    ".py",
    ".html",
    ".js",
    ".mjs",
    ".css",
    ".toml",
    ".json",
    ".c",
    ".cc",
    ".h",
    ".cu",
    ".md",
    ".st",
    ".xml",
    ".txt",
    ".tex",
}
CARRIED |= {
    ".typed",
    ".comp",
    ".hal",
    ".jinja",
    ".cpp",
    ".yaml",
}  # of LinuxCNC; Python for robot simulators; ROS 2
LICENCES = """
import json
from importlib.metadata import distributions
def licence(of):
    told = of.metadata
    kinds = [line.rsplit(" :: ", 1)[1] for line in told.get_all("Classifier") or [] if line.startswith("License ::")]
    return told.get("License-Expression") or "; ".join(kinds) or (told.get("License") or "unknown").splitlines()[0]
print(json.dumps({of.metadata["Name"]: [of.version, licence(of)] for of in distributions()}))
"""


def run(*command: object, folder: Path | None = None) -> str:
    """Run a command and return what it prints; whatever fails ends the check with its words."""
    done = subprocess.run(
        [str(part) for part in command], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def built(out: Path) -> tuple[Path, Path]:
    """Build both into a folder, and return the wheel and the sdist."""
    run(sys.executable, "-m", "build", "--outdir", out, ROOT)
    wheel, sdist = next(out.glob("*.whl")), next(out.glob("*.tar.gz"))
    print(run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist).strip())
    return wheel, sdist


def looked_inside(wheel: Path, sdist: Path) -> None:
    """Compare the wheel with the package, file by file, and look for what is not to travel."""
    inside = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("bristle/")}
    wanted = {
        PurePosixPath(file.relative_to(ROOT / "src")).as_posix()
        for file in (ROOT / "src" / "bristle").rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    odd = sorted(name for name in inside if PurePosixPath(name).suffix not in CARRIED)
    if inside != wanted or odd:
        raise SystemExit(
            f"wheel: missing {sorted(wanted - inside)}, unexpected {sorted(inside - wanted)}, forbidden {odd}"
        )
    with tarfile.open(sdist) as archive:
        names = {
            PurePosixPath(*PurePosixPath(name).parts[1:]).as_posix() for name in archive.getnames()
        }
    lacking = {"LICENSE", "README.md", "CHANGELOG.md", "CITATION.cff", "pyproject.toml"} - names
    if lacking or any(
        name.startswith(".") and name != "." and name != ".gitignore" for name in names
    ):
        raise SystemExit(
            f"files missing in the sdist: {sorted(lacking)}, or it contains hidden files"
        )
    sizes = [f"{one.name}: {one.stat().st_size / 1e6:.1f} MB" for one in (wheel, sdist)]
    print(f"{'; '.join(sizes)}; {len(inside)} files in the wheel")


def demonstrated(wheel: Path, work: Path) -> Path:
    """Install the wheel in a new environment, run the demonstration there, and return the folder of its programs."""
    run(sys.executable, "-m", "venv", work / "venv")
    programs = work / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    run(programs / "python", "-m", "pip", "install", "--quiet", wheel)
    run(programs / "bristle", "demo", folder=work)
    print("pip install, bristle demo:", report_of(work))
    return programs


def report_of(work: Path) -> str:
    """Return that a report was written, and remove it."""
    report = work / "bristle-demo" / "report.html"
    size = report.stat().st_size
    shutil.rmtree(report.parent)
    return f"a report of {size / 1e6:.1f} MB"


def licences(programs: Path) -> None:
    """Print the licence of everything that is installed beside bristle; one of the GPL family ends the check."""
    found = json.loads(run(programs / "python", "-c", LICENCES))
    for name, (version, licence) in sorted(found.items(), key=lambda item: item[0].lower()):
        print(f"  {name} {version}: {licence}")
    bad = [
        name
        for name, (_, licence) in found.items()
        if licence == "unknown" or "GPL" in licence.replace("LGPL", "")
    ]
    if bad:
        raise SystemExit(f"licence of the GPL family, or no stated licence: {', '.join(bad)}")


def main() -> None:
    """Do all of it, and say what was seen."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, help="new folder for wheel and sdist")
    parser.add_argument(
        "--licences", action="store_true", help="print the licences of the installed packages"
    )
    parser.add_argument("--quick", action="store_true", help="only build and check the contents")
    asked = parser.parse_args()
    if asked.out and asked.out.exists():
        raise SystemExit(f"{asked.out} exists already. State a new folder")
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        wheel, sdist = built(asked.out or work / "dist")
        looked_inside(wheel, sdist)
        if asked.quick:
            return
        programs = demonstrated(wheel, work)
        version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
            "version"
        ]
        print(run(programs / "bristle", "--version").strip(), "is", version)
        if asked.licences:
            licences(programs)
        if shutil.which("uv"):
            run("uv", "tool", "run", "--from", wheel.resolve(), "bristle", "demo", folder=work)
            print("uv tool run, bristle demo:", report_of(work))
        else:
            print("uv is not installed: bristle demo was not tested with uv tool run")


if __name__ == "__main__":
    main()
