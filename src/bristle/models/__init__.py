"""Models of an axis, each in a file: friction, hysteresis operators, plants, controllers, sensors, references.

A model states its equation and its source, and imports only `core`. It knows no log, no file and no figure.
"""
