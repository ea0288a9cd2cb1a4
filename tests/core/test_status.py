"""How a computation ended, in words and in order of severity."""

from bristle.core.status import Status


def test_each_status_has_a_distinct_sentence():
    sentences = [status.sentence for status in Status]
    assert all(sentences)
    assert len(set(sentences)) == len(sentences)
    assert Status.OK.sentence == "completed"


def test_codes_rank_by_severity():
    ranked = (
        Status.OK,
        Status.SOLVE_INACCURATE,
        Status.TOLERANCE_MISSED,
        Status.MEMORY_OVERFLOW,
        Status.NOT_FINITE,
    )
    assert sorted(Status, key=int) == list(ranked)
