"""Arrays beside results: what is written is read again, and no library is loaded that is not needed."""

import subprocess
import sys

import numpy as np
import pytest

from bristle.files.arrays import read_arrays, write_arrays
from bristle.files.results import results_folder

ARRAYS = {"time": np.arange(5.0)[::-1], "draws": np.arange(10.0).reshape(5, 2)[::-1]}


def test_arrays_of_1_and_2_dimensions_survive_a_round_trip(tmp_path):
    pytest.importorskip("pyarrow")
    with results_folder(tmp_path / "out") as folder:
        assert write_arrays(folder, "traces", ARRAYS) == "traces.parquet"
    result = read_arrays(tmp_path / "out", "traces")
    assert list(result) == list(ARRAYS)
    for name, values in ARRAYS.items():
        np.testing.assert_array_equal(result[name], values)


def test_parquet_is_written_without_pandas(tmp_path):
    pytest.importorskip("pyarrow")
    code = (
        "import sys; import numpy as np; from pathlib import Path; from bristle.files.arrays import write_arrays; "
        "from bristle.files.results import results_folder\n"
        f"with results_folder(Path({str(tmp_path / 'out')!r})) as folder:\n"
        "    write_arrays(folder, 'draws', {'a': np.zeros(3), 'b': np.zeros((3, 2))})\n"
        "print('pandas' in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"
