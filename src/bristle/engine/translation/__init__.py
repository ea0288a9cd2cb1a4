"""Kernels as a typed tree, from which bristle writes other languages and derivatives."""
