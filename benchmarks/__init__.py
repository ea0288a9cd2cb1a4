"""Benchmarks: error and time together, each as a ratio against something run beside it."""
