"""Each skipped test in a summary with its reason; with ``--ci``, a reason outside `tests.needs` fails the run."""

from collections import Counter

import pytest
from tests.needs import allowed_reason

# Reasons of skipped tests, and how many tests state each. Files that are skipped as a whole are counted apart: each worker collects
# all of them, and xdist reports none.
REASONS = Counter()
FILES = Counter()


def pytest_addoption(parser):
    group = parser.getgroup("bristle")
    group.addoption(
        "--ci",
        action="store_true",
        help="fail where a test is skipped for a reason that is not allowed",
    )


def pytest_configure(config):
    """Begin to count."""
    REASONS.clear()
    FILES.clear()


def pytest_runtest_logreport(report):
    """Count a skipped test."""
    if report.skipped and not hasattr(report, "wasxfail"):
        REASONS[reason_of(report)] += 1


def pytest_collectreport(report):
    """Count a skipped file."""
    if report.skipped:
        FILES[reason_of(report)] += 1


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """Take the skipped files from one worker."""
    FILES.update(getattr(node, "workeroutput", {}).get("skipped files", {}) if not FILES else {})


def reason_of(report):
    """Return the reason that a report of a skip states."""
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return text.removeprefix("Skipped: ")


def refused():
    """Return the reasons that are not allowed."""
    return [reason for reason in REASONS + FILES if allowed_reason(reason) is None]


def pytest_terminal_summary(terminalreporter, config):
    """Report what was skipped, and why."""
    reasons = REASONS + FILES
    if not reasons:
        return
    terminalreporter.section(
        f"{REASONS.total()} tests and {FILES.total()} files skipped, by reason"
    )
    for reason, number in sorted(reasons.items()):
        name = allowed_reason(reason) or "NOT ALLOWED"
        terminalreporter.write_line(f"{number:5d}  {name}: {reason}")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_sessionfinish(session, exitstatus):
    """Fail a run of CI that skipped a test for another reason; a worker hands over what it has not collected."""
    result = yield
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["skipped files"] = dict(FILES)
    elif session.config.getoption("ci") and refused():
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
    return result
