"""Closed forms for a spherical membrane of the bud's size: references of the hard cases."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

P, MU, H, R = 0.20265, 40.0, 0.1, 2.5  # turgor, shear modulus, thickness, radius: MPa, µm


def balloon(stretch: float, alpha: float) -> float:
    """Return p R/(μ h) of a spherical elastic membrane with Ogden's energy."""
    return 4 / alpha * (stretch ** (alpha - 3) - stretch ** (-2 * alpha - 3))


def inflated(pressure: float, alpha: float = 2.0, mu: float = MU, h: float = H) -> float:
    """Return V/V0 of that membrane under a pressure."""
    load = pressure * R / (mu * h)
    return brentq(lambda x: balloon(x, alpha) - load, 0.5, 7 ** (1 / 6), xtol=1e-14) ** 3


def sphere_burst() -> float:
    """Return the time in min at which a membrane that grows everywhere loses equilibrium.

    With growth stretch g and elastic stretch e, p R/(μ h) g³ = 2 (1/e - e⁻⁷), and each of the two
    growth strains grows by (√2 σ/σ_trs - 1)/(√2 t_grw) with the Cauchy stress σ = p R e g/(2 h).
    """
    load = P * R / (MU * H)

    def time_by_stretch(e: float) -> float:
        g3 = balloon(e, 2.0) / load
        by_e = -2 * e**-2 + 14 * e**-8
        stress = P * R * e * g3 ** (1 / 3) / (2 * H)
        rate = (2**0.5 * stress - 1) / (2**0.5 * 45)
        return by_e / balloon(e, 2.0) / 3 / rate

    start = inflated(P) ** (1 / 3)
    return quad(time_by_stretch, start, 7 ** (1 / 6))[0]


def buckling(h: float) -> float:
    """Return the classical external buckling pressure of a thin sphere, E = 3μ, ν = 1/2."""
    return 2 * 3 * MU * h**2 / (R**2 * np.sqrt(3 * (1 - 0.25)))
