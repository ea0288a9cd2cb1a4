"""Compute friction along a prescribed motion: break-away, sliding, and the change of sign after a reversal."""

import numpy as np

import bristle as br

model = br.friction.lugre(
    F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 N*s/mm"
)
print(model)

dt = 1e-4  # s
t = np.arange(0.0, 2.0, dt)
x = 1e-3 * np.sin(np.pi * t) ** 2  # a stroke of one millimetre forth and back, twice
F = br.response(model, x, dt)

turn = round(0.5 / dt)
flipped = np.flatnonzero(F[turn:] < 0.0)[0] + turn
print(f"largest force: {F.max():.2f} N")
print(f"force just before the reversal: {F[turn - 1]:.2f} N")
print(f"the force changes sign {1e6 * (x[turn] - x[flipped]):.2f} um after the reversal")
