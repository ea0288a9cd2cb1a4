"""Which tests run, in which process and in which order: files that take long begin first, and no file is split."""

from collections import Counter

import pytest

# Folders whose tests share what takes long to make: the figures of the source paper, the page of all models.
TOGETHER = ("tests/apps/paper/", "tests/apps/lab/")
# What takes long begins first, so that no worker is left with it at the end.
FIRST = (
    "tests/identification/",
    *TOGETHER,
    "tests/exports/",
    "tests/cli/",
    "tests/engine/",
    "tests/apps/tune/",
    "tests/apps/lab/server/",
)


def pytest_addoption(parser):
    group = parser.getgroup("bristle")
    group.addoption(
        "--share",
        metavar="K/N",
        type=share_named,
        help="run the K-th of N shares of the files, 1/3 for the first third",
    )


def share_named(text):
    """Return position and number of shares."""
    position, _, number = text.partition("/")
    share = int(position), int(number)
    if not 1 <= share[0] <= share[1]:
        raise ValueError(f"{text}: a share is K/N with K from 1 to N")
    return share


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give each file to one worker, and folders that share what takes long to make to one together."""
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return scope_of(nodeid)

    config.option.loadscopereorder = False
    return Scheduling(config, log)


def scope_of(nodeid):
    """Return what names the tests that one worker gets together."""
    together = [folder for folder in TOGETHER if nodeid.startswith(folder)]
    return together[0] if together else nodeid.partition("::")[0]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark what is slow of parametrised tests, keep one share of the files, and begin with what takes long."""
    mark_further_cases(items)
    keep_share(config, items)
    items.sort(key=rank)


def mark_further_cases(items):
    """Leave the first cases of a test that says ``fast_cases(N)`` among the fast tests; the others are slow."""
    seen = Counter()
    for item in items:
        mark = item.get_closest_marker("fast_cases")
        if mark is None:
            continue
        name = item.nodeid.partition("[")[0]
        seen[name] += 1
        if seen[name] > mark.args[0]:
            item.add_marker("slow")


def keep_share(config, items):
    """Deselect the tests of other shares: files with slow tests are dealt out in turn, so that each share gets some of each folder."""
    share = config.getoption("share")
    if share is None:
        return
    position, number = share
    files = sorted({scope_of(item.nodeid) for item in items if item.get_closest_marker("slow")})
    kept = set(files[position - 1 :: number])
    others = [item for item in items if scope_of(item.nodeid) not in kept]
    items[:] = [item for item in items if scope_of(item.nodeid) in kept]
    config.hook.pytest_deselected(items=others)


def rank(item):
    """Return a smaller number for a folder that begins earlier."""
    places = [place for place, name in enumerate(FIRST) if item.nodeid.startswith(name)]
    return places[0] if places else len(FIRST)
