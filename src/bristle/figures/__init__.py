"""Figures, one a file: each a function from results to a `matplotlib.figure.Figure`; the only importers of matplotlib.

Every figure is readable in grey: lines differ in lightness and dashes and markers in shape, besides their colour.
"""
