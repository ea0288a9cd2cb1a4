"""Reports: one self-contained HTML file each, which asks for nothing from outside and prints on A4."""
