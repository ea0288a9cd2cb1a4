"""Model files of operators: every number comes back, and what does not fit is refused."""

import pytest

from bristle import hysteresis
from bristle.core.errors import InputError
from bristle.files.operator import (
    OperatorFile,
    contact_over,
    holds_operator,
    operator_beside,
    read_operator,
    with_operator,
    write_operator,
)

WRITTEN = [name for name in hysteresis.OPERATORS if name not in ("stop", "play")]


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("kind", ["translational", "rotational", "magnetic", "piezo"])
def test_numbers_survive_a_round_trip_exactly(tmp_path, name, kind):
    component = hysteresis.OPERATORS[name]
    operator = component(kind=kind, **component.example)
    write_operator(
        tmp_path / "model.toml", operator, 1.0 / 3.0, provenance={"command": 'a "quoted" one'}
    )
    result = read_operator(tmp_path / "model.toml")
    assert (result.operator, result.offset, result.provenance) == (
        operator,
        1.0 / 3.0,
        {"command": 'a "quoted" one'},
    )
    assert holds_operator(tmp_path / "model.toml")


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ("schema = 1", "schema = 2", "schema"),
        ("schema = 1", "schema = 1\noffset = 2.0", "offset: unknown key"),
        ('kind = "translational"', 'kind = "magic"', "kind: unknown kind"),
        ('model = "prandtl_ishlinskii"', 'model = "prandtl"', "operator.model"),
        ("offset = 0.0", "offset = nan", "output.offset: must be a finite number"),
        ("offset = 0.0", "level = 0.0", "output.level: unknown key"),
        ("spring = 100000.0", 'spring = "1 N"', "operator.spring"),
        ("thresholds = [1e-06, ", "thresholds = [", "of the same length"),
    ],
)
def test_invalid_operator_files_are_refused(tmp_path, was, now, said):
    component = hysteresis.prandtl_ishlinskii
    write_operator(tmp_path / "model.toml", component(**component.example))
    text = (tmp_path / "model.toml").read_text()
    assert was in text
    (tmp_path / "model.toml").write_text(text.replace(was, now))
    with pytest.raises(InputError, match=f"model.toml.*{said}"):
        read_operator(tmp_path / "model.toml")


@pytest.mark.parametrize("offset", [0.0, 2.5])
def test_an_operator_for_a_kernel_is_named_by_its_file_or_by_its_table(tmp_path, offset):
    component = hysteresis.prandtl_ishlinskii
    made = component(**component.example)
    write_operator(tmp_path / "kernel.toml", made, offset)
    read = operator_beside(tmp_path)
    beside = {"offset": offset} if offset else {}
    for kernel in ("kernel.toml", {"file": "kernel.toml"}):
        entries = {"model": "preisach_contact", "kernel": kernel}
        assert with_operator(entries, "translational", "friction", read) == beside | {
            "model": "preisach_contact",
            "kernel": made,
        }
        # What is told goes before.
        assert (
            with_operator(entries | {"offset": 7.0}, "translational", "friction", read)["offset"]
            == 7.0
        )
    table = {"kernel": {"model": "play", "r": "1 um"}}
    assert with_operator(table, "translational", "friction", read)["kernel"].values == {"r": 1e-6}
    assert with_operator({"kernel": made}, "translational", "friction", read) == {"kernel": made}
    contact = contact_over(OperatorFile(made, offset, {}))
    assert contact == beside | {"model": "preisach_contact", "kernel": made}
