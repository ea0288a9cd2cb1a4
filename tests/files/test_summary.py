"""Results as JSON."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from bristle.files.summary import as_json

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


def without_what_json_lacks(value):
    if isinstance(value, dict):
        return {key: without_what_json_lacks(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_what_json_lacks(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@pytest.mark.slow
@given(st.dictionaries(st.text(), values))
def test_finite_numbers_survive_a_round_trip(data):
    text = as_json(data)
    assert text.isascii()
    assert json.loads(text) == without_what_json_lacks(data)


def test_numpy_tuples_and_paths_become_plain(tmp_path):
    data = {
        "a": np.array([1.0, np.nan]),
        "b": np.float64(2.5),
        "c": (1, np.int64(2)),
        "d": np.bool_(True),
        "e": tmp_path,
    }
    assert json.loads(as_json(data)) == {
        "a": [1.0, None],
        "b": 2.5,
        "c": [1, 2],
        "d": True,
        "e": str(tmp_path),
    }
