"""Applications beside the rooms: each brings its command, its pages and its figures.

An app imports public names of rooms, and of other apps only what `pyproject.toml` lists. No room imports an app.
"""
