"""Check a friction model of your own against the contract, compute its force, and simulate an axis with it."""

import numpy as np
from quadratic_drag import MODEL

import bristle as br
from bristle.contract import check_model
from bristle.engine import run_open_loop

for check in check_model(MODEL):
    print(f"{'met' if check.passed else 'NOT MET'}: {check.name}")

model = MODEL(F_C="20 N", F_q="125 N*s^2/m^2")
F = br.response(model, np.linspace(0.0, 0.4, 401), dt=1e-3)  # at 1 m/s
print(f"force at 1 m/s: {F[-1]:.3f} N")

table = br.plants.inertia(M=5.0)
moving = run_open_loop(table, model, np.full(4000, 100.0), 1e-3)
stuck = run_open_loop(table, model, np.full(1000, 10.0), 1e-3)
print(f"speed under 100 N: {moving.velocity[-1]:.4f} m/s")
print(f"under 10 N: friction {stuck.friction[-1]:.3f} N, speed {stuck.velocity[-1]} m/s")
