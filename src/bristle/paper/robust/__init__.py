"""Compensation on frictions of other kinds and under changed conditions: who is compensated is not who was modelled."""
