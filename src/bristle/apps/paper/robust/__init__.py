"""Compensation with other kinds of friction and under changed conditions: the plant differs from the model."""
