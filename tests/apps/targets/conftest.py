"""What tests of exports share: FMUs, which take long to compile."""

import os
import time

import pytest
from tests.exports.importing import PLANT, STEP, WRITTEN, Importer, example

import bristle as br
from bristle.apps.targets import fmu
from bristle.files.owned import lock

AS_FOR_A_PERSON = ("lugre_2", "coulomb_3")


def alone(note):
    """Wait until no other worker has a lock."""
    while True:
        try:
            lock(note)
        except BlockingIOError:
            time.sleep(0.1)
        else:
            return


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """FMUs of some models, of one for both versions; workers of one run share them."""
    place = tmp_path_factory.getbasetemp()
    folder = (place.parent if "PYTEST_XDIST_WORKER" in os.environ else place) / "written"
    with (
        pytest.MonkeyPatch.context() as patch,
        open(f"{folder}.lock", "w", encoding="ascii") as note,
    ):
        alone(note.fileno())
        folder.mkdir(exist_ok=True)
        patch.setattr(fmu, "zig", list)  # other platforms take minutes, and cannot be run here
        flags = fmu.FLAGS
        for name in WRITTEN:
            # Most take a compiler half as long so; some are built as they are for a person.
            patch.setattr(fmu, "FLAGS", flags if name in AS_FOR_A_PERSON else f"{flags} -O1")
            if not (folder / name).exists():
                br.export(example(name), f"fmu{name[-1]}", folder / name, step=STEP, plant=PLANT)
    return folder


@pytest.fixture
def opened(fmus, tmp_path):
    """Return an FMU that is instantiated by FMPy: of those above by its name, any other by its folder."""
    open_ones = []

    def open_one(name, mass=False, exchanged=False):
        path = fmus / name / f"axis_x{'_mass' * mass}.fmu"
        open_ones.append(Importer(path, tmp_path / f"unpacked_{len(open_ones)}", exchanged))
        return open_ones[-1]

    yield open_one
    for each in open_ones:
        each.close()
