"""A report in a browser."""

from tests.apps.lab.browser import shown  # noqa: F401
