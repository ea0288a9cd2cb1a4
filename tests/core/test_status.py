"""How a computation ended, in words and in order of severity."""

from bristle.core.status import Status


def test_each_status_says_something_of_its_own():
    sentences = [status.sentence for status in Status]
    assert all(sentences)
    assert len(set(sentences)) == len(sentences)
    assert Status.OK.sentence == "completed"


def test_the_worst_of_several_is_the_one_that_tells_most():
    ranked = (Status.OK, Status.SOLVE_INACCURATE, Status.TOLERANCE_MISSED, Status.MEMORY_OVERFLOW, Status.NOT_FINITE)
    assert sorted(Status, key=int) == list(ranked)
