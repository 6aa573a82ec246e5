"""Stress drops of an event from maps of stress drop and slip over its cells (Noda, Lapusta and Kanamori 2013)."""

import numpy as np


def of_area(drop, area):
    """The mean over the area that ruptured [Pa]."""
    return float((drop * area).sum() / area.sum())


def of_energy(drop, slip, area):
    """The mean weighted by slip [Pa], which is in the energy of an event: half of it times moment over shear modulus is
    the strain energy that its slip sets free beside what the final stress takes."""
    return float((drop * slip * area).sum() / (slip * area).sum())


def of_moment(moment, area, poisson_ratio=0.25):
    """That of a circular crack with this moment [N m] and area [m^2] (Eshelby 1957): 3 (2 - nu)/(16 (1 - nu))
    moment/a^3, at 1/4 the 7/16 moment/a^3 of seismology [Pa]."""
    return 3 * (2 - poisson_ratio) / (16 * (1 - poisson_ratio)) * moment / (area / np.pi) ** 1.5
