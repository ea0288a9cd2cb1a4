"""Axes in LinuxCNC's HAL for tests and benchmarks of `bristle tune`, without hardware."""
