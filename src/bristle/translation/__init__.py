"""Kernels as a typed tree: what every other language is printed from, and the derivatives."""
