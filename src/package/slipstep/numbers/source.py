"""Of a moment-rate function: its spectrum, corner frequencies and durations. Functions take times [n], ascending, in s,
and rates [n] in N m/s, which go by straight lines between and are zero outside."""

import numpy as np

# a spectrum is fitted from this fraction to this multiple of the corner by integrals; farther up the fall-off of smooth
# sources is not that of any corner
BAND = 5.0
POINTS = 400  # frequencies of a fit, evenly in their logarithm


def moments(time, rate):
    """Moment [N m], centroid time [s] and variance [s^2] of the rate over time, exact for straight lines."""
    a, b, h, t = rate[:-1], rate[1:], np.diff(time), time[:-1]
    m = (h * (a + b) / 2).sum()
    first = (h * (t * (a + b) / 2 + h * (a + 2 * b) / 6)).sum()
    centroid = first / m
    t = t - centroid
    second = (h * (t ** 2 * (a + b) / 2 + t * h * (a + 2 * b) / 3 + h ** 2 * (a + 3 * b) / 12)).sum()
    return m, centroid, second / m


def durations(time, rate, share=0.05):
    """Seconds: between `share` of the moment and all but `share` of it, and twice the standard deviation of the rate
    over time (McGuire 2004). Of a box of length T: 0.9 T, and T/sqrt(3)."""
    h = np.diff(time)
    so_far = np.concatenate([[0.0], np.cumsum(h * (rate[1:] + rate[:-1]) / 2)])

    def reached(level):
        k = int(np.clip(np.searchsorted(so_far, level) - 1, 0, len(h) - 1))
        rest, a, slope = level - so_far[k], rate[k], (rate[k + 1] - rate[k]) / h[k]
        root = np.sqrt(max(a * a + 2 * slope * rest, 0.0))
        return time[k] + (2 * rest / (a + root) if a + root > 0 else 0.0)

    return reached((1 - share) * so_far[-1]) - reached(share * so_far[-1]), 2 * np.sqrt(moments(time, rate)[2])


def spectrum(time, rate, frequency):
    """Amplitudes [N m] of the Fourier transform at frequencies [m] in Hz, exact for straight lines at any spacing of
    times."""
    half, middle = np.diff(time) / 2, (time[1:] + time[:-1]) / 2
    mean, change = (rate[1:] + rate[:-1]) / 2, (rate[1:] - rate[:-1]) / 2
    found = np.empty(len(frequency))
    for k, f in enumerate(frequency):
        x = 2 * np.pi * f * half
        small = x < 1e-2
        safe = np.where(small, 1.0, x)
        even = np.where(small, 1 - x ** 2 / 6 + x ** 4 / 120, np.sin(safe) / safe)
        odd = np.where(small, x / 3 - x ** 3 / 30 + x ** 5 / 840, (np.sin(safe) - safe * np.cos(safe)) / safe ** 2)
        found[k] = abs((np.exp(-2j * np.pi * f * (middle - time[0])) * 2 * half
                        * (mean * even - 1j * change * odd)).sum())
    return found


def corner_of_integrals(time, rate):
    """Corner frequency [Hz] from the integrals of the squared rate and of its squared derivative (Andrews 1986); no
    band and no fit. Of Brune's spectrum it is the corner; the rate must be continuous, from 0 to 0."""
    h, a, b = np.diff(time), rate[:-1], rate[1:]
    return np.sqrt(((b - a) ** 2 / h).sum() / (h * (a * a + a * b + b * b) / 3).sum()) / (2 * np.pi)


def golden(misfit, grid):
    """Where a function is least between the neighbours of its least on a grid: golden section, to rounding."""
    best = int(np.argmin([misfit(value) for value in grid]))
    low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    ratio = (np.sqrt(5) - 1) / 2
    for _ in range(60):
        a, b = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, b) if misfit(a) < misfit(b) else (a, high)
    return (low + high) / 2


def brune(frequency, moment, corner, falloff=2.0):
    """Amplitudes [N m] of the spectrum of Brune (1970), moment/(1 + (f/corner)^falloff)."""
    return moment / (1 + (frequency / corner) ** falloff)


def fit_brune(frequency, amplitude, moment):
    """Corner frequency [Hz] of the omega-square spectrum with a given moment, least squares of the logarithms, and
    their root mean square (natural logarithm)."""
    def misfit(log_corner):
        return np.mean(np.log(amplitude / brune(frequency, moment, np.exp(log_corner))) ** 2)

    best = golden(misfit, np.linspace(np.log(frequency[0]) - 7, np.log(frequency[-1]) + 7, 400))
    return float(np.exp(best)), float(np.sqrt(misfit(best)))


def corner_frequency(time, rate):
    """(corner [Hz], root mean square of the logarithm): fit_brune() of the spectrum within BAND about Andrews' corner,
    below what the times resolve."""
    guess = corner_of_integrals(time, rate)
    high = min(BAND * guess, 0.5 / np.median(np.diff(time)))
    frequency = np.geomspace(guess / BAND, max(high, 2 * guess), POINTS)
    return fit_brune(frequency, spectrum(time, rate, frequency), moments(time, rate)[0])
