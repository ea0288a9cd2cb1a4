"""Each skipped test in a summary with its reason; with ``--ci``, a reason outside `tests.needs` fails the run."""

from collections import Counter

import pytest
from tests.needs import allowed_reason

# Reasons of skipped tests, and how many tests state each.
REASONS = Counter()


def pytest_addoption(parser):
    group = parser.getgroup("bristle")
    group.addoption("--ci", action="store_true", help="fail where a test is skipped for a reason that is not allowed")


def pytest_configure(config):
    """A run counts its own skips."""
    if not hasattr(config, "workerinput"):
        REASONS.clear()


def pytest_runtest_logreport(report):
    """Count a skipped test."""
    if report.skipped and not hasattr(report, "wasxfail"):
        REASONS[reason_of(report)] += 1


def pytest_collectreport(report):
    """Count a skipped file as one test."""
    if report.skipped:
        REASONS[reason_of(report)] += 1


def reason_of(report):
    """Return the reason that a report of a skip states."""
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return text.removeprefix("Skipped: ")


def refused():
    """Return the reasons that are not allowed."""
    return [reason for reason in REASONS if allowed_reason(reason) is None]


def pytest_terminal_summary(terminalreporter, config):
    """Say what was skipped, and why."""
    if not REASONS:
        return
    terminalreporter.section(f"{REASONS.total()} skipped, by reason")
    for reason, number in sorted(REASONS.items()):
        name = allowed_reason(reason) or "NOT ALLOWED"
        terminalreporter.write_line(f"{number:5d}  {name}: {reason}")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_sessionfinish(session, exitstatus):
    """Fail a run of CI that skipped a test for another reason."""
    result = yield
    is_collecting = not hasattr(session.config, "workerinput")
    if is_collecting and session.config.getoption("ci") and refused():
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
    return result
