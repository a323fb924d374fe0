"""Growth laws, equations (12) and (13) of the paper.

A growth rate is a function of a `WallPoint` and returns the rates of `(ε1^g, ε2^g)` in 1/min,
a UFL vector of two components.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import ufl

# Keeps the derivative of ‖τ‖ finite at τ = 0; far below any stress that matters, in MPa².
_TINY = 1e-24


class WallPoint(NamedTuple):
    """State of the wall at a point, which a growth law may read; UFL vectors of two components.

    Attributes
    ----------
    tau
        Principal Kirchhoff stresses `τ1, τ2` in MPa.
    eps
        Total logarithmic strains.
    eps_g
        Growth part of the logarithmic strains.
    eps_3
        Logarithmic strain through the wall; None for constant thickness, `λ3 = 1`.
    """

    tau: Any
    eps: Any
    eps_g: Any
    eps_3: Any = None

    @property
    def J(self) -> Any:
        """The Jacobian `J = λ1 λ2 λ3` of the deformation."""
        if self.eps_3 is None:
            return ufl.exp(self.eps[0] + self.eps[1])
        return ufl.exp(self.eps[0] + self.eps[1] + self.eps_3)


GrowthRate = Callable[[WallPoint], Any]


def dissipation(point: WallPoint, rate: Any) -> Any:
    """Return the dissipation `τ · dε^g/dt` per unit reference volume in MPa/min: equation (12)."""
    return ufl.dot(point.tau, rate)


def norm(tau: Any) -> Any:
    """Return `‖τ‖ = sqrt(τ1² + τ2²)`."""
    return ufl.sqrt(tau[0] ** 2 + tau[1] ** 2 + _TINY)


def stress_driven(point: WallPoint, sigma_trs: Any, t_grw: Any, of_stress: Any = 1) -> Any:
    """Return the rate of growth along the stress, driven by its excess over a threshold: (13).

    Parameters
    ----------
    point
        State of the wall at the point.
    sigma_trs
        Threshold of the true stress in MPa.
    t_grw
        Characteristic growth time in min.
    of_stress
        Weight of polarised growth, by which the threshold is divided.
    """
    size = norm(point.tau)
    excess = of_stress * size / (point.J * sigma_trs) - 1
    return ufl.conditional(ufl.gt(excess, 0), excess, 0) / t_grw * point.tau / size


@cache
def weighted(rate: Callable[..., Any]) -> Callable[..., Any]:
    """Return a growth rate multiplied by a weight of polarised growth, its parameter `of_rate`."""

    def product(point: WallPoint, of_rate: Any, **parameters: Any) -> Any:
        return of_rate * rate(point, **parameters)

    return product
