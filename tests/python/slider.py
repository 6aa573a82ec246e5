"""One block with rate-and-state friction, by other means than the program's: ln V, psi = ln(V0 theta/d_c) and u as
differential equations, the first by differentiating the balance in time, so that no balance is ever solved; in extended
precision, by extrapolation of the midpoint rule (Gragg 1965, Bulirsch & Stoer 1966)."""

import numpy as np

Real = np.longdouble
STEPS = [2, 4, 6, 8, 10, 12, 14, 16]  # of the midpoint rule: order 16


class Slider:
    def __init__(self, K, eta, sigma, a, b, slip, reference, rate, loading, law="aging", tolerance=1e-15,
                 cut_off=np.inf, ramp=0, alpha=0, cutoff_rate=np.inf, weakened=0.2, weakening_rate=0.1):
        self.K, self.eta, self.sigma, self.a, self.b, self.slip, self.reference, self.V0, self.loading = map(
            Real, (K, eta, sigma, a, b, slip, reference, rate, loading))
        self.law, self.tolerance, self.cutoff_rate = law, Real(tolerance), Real(cutoff_rate)
        self.weakened, self.weakening_rate = Real(weakened), Real(weakening_rate)  # of strong rate weakening
        self.floor = self.V0 / Real(cut_off)  # V0 theta/d_c of examples/friction_law.c is as if it were larger by that
        # d sigma/dt [Pa/s], and what it does to the state (Linker & Dieterich 1992)
        self.ramp, self.alpha = Real(ramp), Real(alpha)

    def change(self, y):
        """d(ln V, psi, u, sigma)/dt; y[2] is slip beyond that of the loading"""
        V = np.exp(y[0])
        if self.law == "aging":
            state = self.V0 / self.slip * np.exp(-y[1]) - V / self.slip
        elif self.law == "prz":
            theta = self.slip / self.V0 * np.exp(y[1])
            state = (1 - (V * theta / (2 * self.slip)) ** 2) / theta
        elif self.law == "strong_rate_weakening":  # psi of Noda, Dunham and Rice (2009) is f0 + b y[1]
            steady = self.a * np.log(2 * self.V0 / V * np.sinh(self.strong(V) / self.a))
            state = -V / self.slip * (self.reference + self.b * y[1] - steady) / self.b
        else:
            state = -V / self.slip * (y[0] - np.log(self.V0) + y[1])
            if self.law == "composite":
                state += self.V0 / self.slip * np.exp(-y[1] - V / self.cutoff_rate)
        state -= self.alpha / self.b * self.ramp / y[3]
        # sigma mu(V, psi) + eta V = T - K u: mu = a asinh(x), x = V/(2 V0) exp((f0 + b g)/a), g = ln(exp(psi) + floor)
        age = np.exp(y[1])
        x = V / (2 * self.V0) * np.exp((self.reference + self.b * np.log(age + self.floor)) / self.a)
        share = x / np.sqrt(1 + x * x)
        by_log_rate = y[3] * self.a * share + self.eta * V
        by_stress = self.a * np.log(x + np.sqrt(1 + x * x)) * self.ramp
        return np.array([(-self.K * (V - self.loading) - by_stress - y[3] * self.b * share * state * age
                          / (age + self.floor)) / by_log_rate, state, V - self.loading, self.ramp], dtype=Real)

    def strong(self, V):
        """Steady friction of strong rate weakening"""
        low = self.reference - (self.b - self.a) * np.log(V / self.V0)
        return self.weakened + (low - self.weakened) / (1 + (V / self.weakening_rate) ** 8) ** Real(0.125)

    def friction(self, log_rate, psi):
        x = np.exp(log_rate) / (2 * self.V0) * np.exp((self.reference + self.b * np.log(np.exp(psi) + self.floor))
                                                      / self.a)
        return self.a * np.log(x + np.sqrt(1 + x * x))

    def stride(self, y, h):
        """State after h, and the difference of the last two columns of the table"""
        rows = []
        for n in STEPS:
            step = h / n
            before, now = y, y + step * self.change(y)
            for _ in range(n - 1):
                before, now = now, before + 2 * step * self.change(now)
            # Gragg's last step
            rows.append((before + now + step * self.change(now)) / 2)
        table, last = list(rows), None
        for column in range(1, len(STEPS)):
            last = table[-1]
            table = [table[i + 1] + (table[i + 1] - table[i]) / ((Real(STEPS[i + column]) / STEPS[i]) ** 2 - 1)
                     for i in range(len(table) - 1)]
        return table[0], table[0] - last

    def run(self, log_rate, psi, end, step=None):
        """(ln V, psi, u) at the end [s]"""
        y, scale = np.array([log_rate, psi, 0, self.sigma],
                            dtype=Real), np.array([1, 1, self.slip, self.sigma], dtype=Real)
        return self.advance(y, scale, end, step or end / 1e4)[:3]

    def advance(self, y, scale, end, step):
        """y at the end [s], errors relative to scale"""
        t, h, end = Real(0), Real(step), Real(end)
        while t < end:
            h = min(h, end - t)
            new, error = self.stride(y, h)
            size = np.max(np.abs(error) / scale) / self.tolerance
            if np.isfinite(size) and size <= 1:
                y, t = new, t + h
            h *= min(2, max(Real(0.2), Real(0.8) * size ** (-1 / Real(15)))) if np.isfinite(size) and size > 0 else (
                Real(0.2) if not np.isfinite(size) else 2)
        return y


class Sliders(Slider):
    """n blocks, K [n, n] the springs between them and to the loading, with several states each: b and slip have one for
    each state, and the friction of a block is that of the sum of b psi."""

    def __init__(self, K, eta, sigma, a, b, slip, reference, rate, loading, law="aging", tolerance=1e-15):
        self.K, self.b, self.slip = (np.atleast_1d(np.array(x, dtype=Real)) for x in (K, b, slip))
        self.eta, self.sigma, self.a, self.reference, self.V0, self.loading, self.tolerance = map(
            Real, (eta, sigma, a, reference, rate, loading, tolerance))
        self.law = law

    def argument(self, log_rate, psi):
        return np.exp(log_rate) / (2 * self.V0) * np.exp((self.reference + self.b @ psi) / self.a)

    def change(self, y):
        """y [2 + states, n]: ln V, psi of each state, u"""
        V, psi, slip = np.exp(y[0]), y[1:-1], self.slip[:, None]
        states = (self.V0 / slip * np.exp(-psi) - V / slip if self.law == "aging"
                  else -V / slip * (y[0] - np.log(self.V0) + psi))
        x = self.argument(y[0], psi)
        share = x / np.sqrt(1 + x * x)
        log_rate = ((-self.K @ (V - self.loading) - self.sigma * share * (self.b @ states))
                    / (self.sigma * self.a * share + self.eta * V))
        return np.vstack([log_rate, states, V - self.loading])

    def friction(self, log_rate, psi):
        return self.a * np.arcsinh(self.argument(log_rate, psi))

    def run(self, log_rate, psi, end, step):
        """(ln V [n], psi [states, n], u [n]) at the end [s], from the same u = 0, of rates [n] and states [states, n]
        or as many numbers"""
        n = len(self.K)
        y = np.vstack([np.full(n, log_rate, dtype=Real), np.full((len(self.b), n), psi, dtype=Real),
                       np.zeros(n, dtype=Real)])
        scale = np.ones(len(y), dtype=Real)
        scale[-1] = self.slip[0]
        y = self.advance(y, scale[:, None], end, step)
        return y[0], y[1:-1], y[-1]
