"""Competitors, one file each: `fit`, and any of `predict`, `feedforward` and `parameters`."""
