"""The loops of a log, ready to be simulated with any model: what its effort or its reference makes of an axis."""
