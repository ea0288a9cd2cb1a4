"""The lab: one page on which friction is touched, with the physics in it."""

from bristle.lab.page import lab_page

__all__ = ["lab_page"]
