"""Reports, each a self-contained HTML file that works offline and prints on A4."""
