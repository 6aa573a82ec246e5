"""One block of a fault that is loaded, weakens with slip and heals at rest, by other means than the program's: Radau's
method of fifth order with steps by doubling while it slides, its ends and its largest rate by roots, and the formula of
its rest.

    M dv/dt + H (v - v_inf) + K u + q(s) = 0,  du/dt = v - v_inf,  ds/dt = v - s/t_h  while v > 0,
            q = sigma (mu + dmu exp(-s/d_c))

Without inertia v follows from u and s. Where the stress after an event exceeds the strength backwards, it slides back:
the same equations with the signs of u, v and v_inf reversed."""

from math import exp, sqrt

import numpy as np

_S = sqrt(6.0)
NODES = np.array([(4 - _S) / 10, (4 + _S) / 10, 1.0])
A = np.array([[(88 - 7 * _S) / 360, (296 - 169 * _S) / 1800, (-2 + 3 * _S) / 225],
              [(296 + 169 * _S) / 1800, (88 + 7 * _S) / 360, (-2 - 3 * _S) / 225],
              [(16 - _S) / 36, (16 + _S) / 36, 1 / 9]])


class Block:
    def __init__(self, K, H, M, sigma, residual, drop, slip, loading, healing, tolerance=1e-10):
        self.K, self.H, self.M, self.sigma, self.residual, self.drop, self.slip = K, H, M, sigma, residual, drop, slip
        self.loading, self.healing, self.tolerance = loading, healing, tolerance
        self.n = 3 if M else 2
        self.step = 1e-3 * H / K

    def strength(self, s):
        return self.sigma * (self.residual + self.drop * exp(-s / self.slip))

    def weakening(self, s):
        return self.sigma * self.drop / self.slip * exp(-s / self.slip)

    # ---- the states y = (u, s), or (u, s, v) with inertia, while it slides ----

    def rate(self, y):
        """Slip rate of a state."""
        return y[2] if self.M else self.loading - (self.K * y[0] + self.strength(y[1])) / self.H

    def change(self, y):
        """dy/dt"""
        v = self.rate(y)
        first = [v - self.loading, v - y[1] / self.healing]
        return np.array(first + ([(-self.H * first[0] - self.K * y[0] - self.strength(y[1])) / self.M] if self.M
                                 else []))

    def acceleration(self, y):
        d = self.change(y)
        return d[2] if self.M else (-self.K * d[0] + self.weakening(y[1]) * d[1]) / self.H

    def jacobian(self, y):
        W, heal = self.weakening(y[1]), 1 / self.healing
        if self.M:
            return np.array([[0, 0, 1], [0, -heal, 1], [-self.K / self.M, W / self.M, -self.H / self.M]])
        return np.array([[-self.K / self.H, W / self.H], [-self.K / self.H, W / self.H - heal]])

    def radau(self, y, h):
        """The state after a step; None when Newton's method does not converge."""
        n = self.n
        z = np.zeros(3 * n)
        for k in range(12):
            at = [y + z[i * n:(i + 1) * n] for i in range(3)]
            if min(a[1] for a in at) < -50 * self.slip:
                return None
            f = np.array([self.change(a) for a in at])
            residual = z - h * (A @ f).ravel()
            matrix = np.eye(3 * n)
            for j in range(3):
                J = self.jacobian(at[j])
                for i in range(3):
                    matrix[i * n:(i + 1) * n, j * n:(j + 1) * n] -= h * A[i, j] * J
            dz = np.linalg.solve(matrix, -residual)
            z = z + dz
            if (np.max(np.abs(dz[-n:]) / self.scale(at[2])) < 1e-3 * self.tolerance
                or (k > 2 and np.max(np.abs(dz)) < 1e-15 * np.max(np.abs(y)))):
                return y + z[-n:]
        return None

    def scale(self, y):
        return np.array([self.slip, self.slip, abs(y[-1]) + self.loading][:self.n])

    def attempt(self, y, h):
        """The state after two half steps, improved by extrapolation, and its error over the tolerance."""
        whole, half = self.radau(y, h), self.radau(y, h / 2)
        end = self.radau(half, h / 2) if half is not None else None
        if whole is None or end is None:
            return None, 1e3
        difference = (end - whole) / 31
        error = np.max(np.abs(difference) / self.scale(end))
        v = self.rate(end)
        error = max(error, 1e-3 * abs(v - self.rate(whole)) / 31 / (abs(v) + self.loading)) if not self.M else error
        return end + difference, error / self.tolerance

    def root(self, y, h, function):
        """The step in (0, h] after which function of the state is zero, and the state."""
        low, high, at_low, at_high = 0.0, h, function(y), function(self.attempt(y, h)[0])
        for k in range(60):
            x = (low * at_high - high * at_low) / (at_high - at_low)
            if k % 4 == 3 or not low < x < high:
                x = (low + high) / 2
            state = self.attempt(y, x)[0]
            value = function(state)
            if (value > 0) == (at_high > 0):
                high, at_high, at_low = x, value, at_low / 2
            else:
                low, at_low, at_high = x, value, at_high / 2
            if high - low < 1e-14 * high or value == 0:
                break
        return x, state

    def slide(self, t, y, until, event):
        """From an onset to rest: time and state then; events are appended to self.events as (onset, end, slip, peak,
        time of it)."""
        h, onset = self.step, None
        while t < until:
            h = min(h, until - t)
            end, error = self.attempt(y, h)
            if error > 1:
                h *= max(0.1, 0.9 * error ** (-1 / 6))
                continue
            stops = self.rate(end) <= 0
            if stops:
                h, end = self.root(y, h, self.rate)
            above = lambda a: self.rate(a) - event
            if above(y) < 0 <= above(end):
                x, a = self.root(y, h, above)
                onset = (t + x, a[0] + self.loading * (t + x))
            if onset and self.acceleration(y) > 0 >= self.acceleration(end) and self.rate(end) > event:
                x, a = self.root(y, h, self.acceleration)
                peak = (self.rate(a), t + x)
            if onset and above(y) >= 0 > above(end):
                x, a = self.root(y, h, above)
                self.events.append((onset[0], t + x, a[0] + self.loading * (t + x) - onset[1], *peak))
                onset = None
            t, y = t + h, end
            self.steps += 1
            if stops:
                return t, y, True
            h *= min(4, max(0.2, 0.9 * max(error, 1e-9) ** (-1 / 6)))
        return t, y, False

    def wait(self, u, s):
        """How long it rests: the only root of the force less the strength beyond their first fall."""
        excess = lambda dt: self.H * self.loading - self.K * (u - self.loading
                                                              * dt) - self.strength(s * exp(-dt / self.healing))
        high = 1e-6 * self.healing
        while excess(high) <= 0:
            high *= 1.5
        low = high / 1.5 if high > 1e-6 * self.healing else 0.0
        for _ in range(200):
            middle = (low + high) / 2
            if excess(middle) > 0:
                high = middle
            else:
                low = middle
        return high

    def run(self, until, count=10 ** 9, event=1e-3):
        """Events from a start without stress, and the times and lengths of rests."""
        t, u, s, self.events, self.rests, self.steps = 0.0, 0.0, 0.0, [], [], 0
        while t < until and len(self.events) < count:
            sign = -1 if self.K * u - self.H * self.loading > self.strength(s) else 1
            if sign > 0:
                dt = self.wait(u, s)
                self.rests.append((t, dt))
                t, u, s = t + dt, u - self.loading * dt, s * exp(-dt / self.healing)
            self.loading *= sign
            t, y, rests = self.slide(t, np.array([sign * u, s, 0.0][:self.n]), until, event)
            self.loading *= sign
            u, s = sign * y[0], y[1]
        return np.array(self.events)
