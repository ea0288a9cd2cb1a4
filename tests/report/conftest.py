"""A report in a browser."""

from tests.lab.browser import shown  # noqa: F401
