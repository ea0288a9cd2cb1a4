"""Fetch DATA_EMPS.mat, the record of the EMPS axis, and accept it only with the right checksum.

Usage: ``python fetch.py [--url URL] [--to FOLDER]``. Needs ``pip install "bristle[fetch]"``.
"""

import argparse
import sys
import tempfile
import zipfile
from pathlib import Path

PUBLISHED = """A. Janot, M. Gautier and M. Brunot publish the data set as a ZIP archive on https://www.nonlinearbenchmark.org
(Electro-Mechanical Positioning System). Download the archive there with a browser, or state its new address with --url."""
# Where the benchmark's own Python loader (nonlinear-benchmarks on PyPI) finds the archive.
URL = "https://drive.google.com/uc?export=download&id=1zwoXYa9-3f8NQ0ohzmjpF7UxbNgRTHkS"
FILE = "DATA_EMPS.mat"
SHA256 = "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--url", default=URL, help="address of the archive or of the MAT file")
    parser.add_argument("--to", type=Path, default=Path(), help="folder for the file")
    chosen = parser.parse_args()
    try:
        import pooch
        from requests import RequestException
    except ImportError:
        return refuse('pooch is missing. Type: pip install "bristle[fetch]"')
    pooch.get_logger().setLevel("WARNING")
    if not chosen.to.is_dir():
        return refuse(f"{chosen.to}: the folder does not exist. Create it first")
    wanted = chosen.to / FILE
    with tempfile.TemporaryDirectory() as folder:
        try:
            arrived = Path(
                pooch.retrieve(chosen.url, known_hash=None, fname="arrived", path=folder)
            )
        except (RequestException, OSError, ValueError) as error:
            return refuse(
                f"{chosen.url}: the download failed ({type(error).__name__}).\n{PUBLISHED}"
            )
        data = content(arrived)
        found = Path(folder) / FILE
        found.write_bytes(data)
        if pooch.file_hash(str(found)) != SHA256:
            return refuse(
                f"{chosen.url}: does not contain the expected {FILE} (its checksum differs).\n{PUBLISHED}"
            )
    wanted.write_bytes(data)
    print(f"{wanted}: {len(data)} bytes, checksum as expected")
    return 0


def content(arrived: Path) -> bytes:
    """Return the MAT file, out of the archive where it is one."""
    if not zipfile.is_zipfile(arrived):
        return arrived.read_bytes()
    with zipfile.ZipFile(arrived) as archive:
        inside = [one for one in archive.namelist() if Path(one).name == FILE]
        return archive.read(inside[0]) if inside else b""


def refuse(message: str) -> int:
    print(f"fetch.py: {message}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
