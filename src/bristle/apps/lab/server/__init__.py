"""The lab as a browser application: from a log dropped on the page to drive tables, without a terminal."""

from bristle.apps.lab.server.limits import Limits
from bristle.apps.lab.server.run import serve

__all__ = ["Limits", "serve"]
