"""The lab as an application in the browser: from a dropped log to numbers for the drive, without a terminal."""

from bristle.server.limits import Limits
from bristle.server.run import serve

__all__ = ["Limits", "serve"]
