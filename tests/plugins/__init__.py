"""Plugins of pytest for these tests: what a test may cost, where its kernels are compiled, in which process it runs, what is skipped."""
