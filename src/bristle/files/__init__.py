"""Files in and out: axis, model, experiment, results."""
