"""Frequency and magnitude: completeness and the b-value of Gutenberg and Richter, with what is uncertain of it."""

import numpy as np


def completeness(magnitude, width=0.1):
    """The magnitude from which on a catalogue is complete, by maximum curvature (Wiemer and Wyss 2000): the largest
    count in bins of a width, its lower edge."""
    bins = np.floor(magnitude / width + 1e-9).astype(int)
    return width * (bins.min() + np.argmax(np.bincount(bins - bins.min())))


def b_value(magnitude, least, width=0.0):
    """b by maximum likelihood, and its standard error b/sqrt(n), of the events from a magnitude on.

    width  0: continuous magnitudes (Aki 1965). Else magnitudes are rounded to multiples of it, least is one of them,
           and b is exact for such bins (Tinti and Mulargia 1987); Utsu's (1966)
           log10(e)/(mean - least + width/2) is its first term, 0.4 % too large at b = 1 and 0.1"""
    above = magnitude[magnitude >= least - 1e-9 * max(width, 0)]
    excess = above.mean() - least
    b = np.log10(np.e) / excess if width == 0 else np.log10(1 + width / excess) / width
    return b, b / np.sqrt(len(above))


def b_error(magnitude, least, b):
    """Standard error of b from the scatter of the magnitudes (Shi and Bolt 1982), which holds also where b changes
    slowly."""
    above = magnitude[magnitude >= least]
    return np.log(10) * b ** 2 * above.std(ddof=1) / np.sqrt(len(above))


def goodness_of_fit(magnitude, least, width=0.1):
    """R [%]: 100 less the sum of differences between the numbers of events from each bin on and those of the law that
    fits, over the sum of the former (Wiemer and Wyss 2000)."""
    above = magnitude[magnitude >= least]
    b, _ = b_value(above, least)
    edges = least + width * np.arange(int((above.max() - least) / width) + 2)
    observed = np.array([(above >= edge - 1e-12).sum() for edge in edges])
    return 100 * (1 - np.abs(observed - len(above) * 10 ** (-b * (edges - least))).sum() / observed.sum())


def completeness_by_fit(magnitude, wanted=(95.0, 90.0), width=0.1, fewest=30):
    """(magnitude, R): the smallest magnitude from which on the law fits to 95 %, else to 90 % (Wiemer and Wyss 2000);
    None: to neither."""
    first = np.floor(magnitude.min() / width + 1e-9)
    candidates = [width * k for k in np.arange(first, np.floor(magnitude.max() / width) + 1)
                  if (magnitude >= width * k).sum() >= fewest]
    found = [(least, goodness_of_fit(magnitude, least, width)) for least in candidates]
    for share in wanted:
        for least, fit in found:
            if fit >= share:
                return least, fit
    return None
