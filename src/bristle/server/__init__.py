"""The lab as an application in the browser: from a dropped log to numbers for the drive, without a terminal."""

from bristle.server.run import Limits, serve

__all__ = ["Limits", "serve"]
