"""Kernels as a typed tree: the source of every other language, and of the derivatives."""
