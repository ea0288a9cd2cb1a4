"""The composite as a differential equation solved from event to event: its own memory, its own branches.

An independent path to the same motion: explicit Runge-Kutta of order 8, stopped wherever the equations change.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

# How far past sliding the ratio goes before its direction counts as reversed: rounding alone would do it for ever.
MARGIN = 1e-11


class Composite:
    """A mass on a contact with the virgin curve s f_p z/(f_p + s z), doubled by Masing's rule."""

    def __init__(self, *, J, s, f_p, F_C, F_S, v_S, sigma_1, sigma_2, rho, effort):
        self.J, self.s, self.f_p, self.F_C, self.F_S, self.v_S = J, s, f_p, F_C, F_S, v_S
        self.sigma_1, self.sigma_2, self.rho, self.effort = sigma_1, sigma_2, rho, effort
        self.turns, self.side, self.way, self.is_open = [], 1.0, 1.0, False

    def hysteretic(self, z):
        def loading(d):
            return self.s * self.f_p * d / (self.f_p + self.s * d)

        if not self.turns:
            return math.copysign(loading(abs(z)), z)
        z_n, f_n = self.turns[-1]
        return f_n + self.way * 2.0 * loading(0.5 * self.way * (z - z_n))

    def ratio(self, y):
        level = self.F_C + (self.F_S - self.F_C) * math.exp(-((y[1] / self.v_S) ** 2))
        return self.side * self.hysteretic(y[2]) / level

    def slip(self, r):
        """The share that slips; no gate where rho is None."""
        if self.rho is None or r >= 1.0:
            return r
        if not self.is_open:
            return 0.0
        return r * math.sin(0.5 * math.pi * (r - self.rho) / (1.0 - self.rho)) ** 2

    def slope(self, t, y):
        x, v, z = y
        z_dot = v * (1.0 - self.slip(self.ratio(y)))
        return [
            v,
            (self.effort(t, x) - self.hysteretic(z) - self.sigma_1 * z_dot - self.sigma_2 * v)
            / self.J,
            z_dot,
        ]

    def end_of_branch(self):
        if not self.turns:
            return self.way * 1e300
        return self.turns[-2][0] if len(self.turns) >= 2 else -self.turns[0][0]

    def events(self):
        end, over = self.end_of_branch(), self.side * self.way
        result = [
            (lambda t, y: y[1], -self.side),
            (lambda t, y: self.ratio(y) - 1.0 - over * MARGIN, over),
            (lambda t, y: self.way * (y[2] - end), 1.0),
            (lambda t, y: self.ratio(y) - (self.rho or -1e300), -1.0 if self.is_open else 1.0),
        ]
        for event, direction in result:
            event.terminal, event.direction = True, direction
        return [event for event, _ in result]

    def turn(self, y, way):
        if way != self.way:
            self.turns.append((y[2], self.hysteretic(y[2])))
            self.way = way

    def solve(self, times, bends=()):
        """Position at some times, from rest and virgin; the effort bends at others."""
        t, y = 0.0, np.zeros(3)
        position = np.zeros(times.size)
        ends = np.append([bend for bend in bends if bend < times[-1]], times[-1])
        while t < times[-1]:
            end = ends[np.searchsorted(ends, t, side="right")]
            part = solve_ivp(
                self.slope,
                (t, end),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
                events=self.events(),
                dense_output=True,
                max_step=1e-3,
            )
            within = (times >= t) & (times <= part.t[-1])
            if np.any(within):
                position[within] = part.sol(times[within])[0]
            t, y = part.t[-1], part.y[:, -1].copy()
            stops, slides, wipes, gates = (t_event.size > 0 for t_event in part.t_events)
            if wipes:
                del self.turns[-2:]
            if gates:
                self.is_open = not self.is_open
            if stops:
                y[1] = 0.0
                way = 1.0 if self.effort(t, y[0]) > self.hysteretic(y[2]) else -1.0
                self.turn(y, way)
                self.side = way
                self.is_open = self.rho is not None and self.ratio(y) > self.rho
            elif slides:
                self.turn(y, -self.way)
        return position
