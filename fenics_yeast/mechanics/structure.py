"""What of a wall decides its compiled forms: walls of one structure differ only in numbers."""

from collections.abc import Hashable
from typing import Any

import numpy as np

from ..geometry import Discretisation
from .growth_weights import follow_tip
from .laws import Law, Parameter
from .section import Approximation, WallProperties


def structure_of(
    discretisation: Discretisation, wall: WallProperties, approximation: Approximation, comm: Any
) -> Hashable:
    """Return a key of all walls that one shell can become: see `Shell.reset`.

    Parameters
    ----------
    discretisation, wall, approximation, comm
        As for `Shell`.
    """
    middles = (discretisation.nodes[1:] + discretisation.nodes[:-1]) / 2
    grows = np.zeros(len(middles), dtype=bool)
    for part in discretisation.growing:
        grows |= part.holds(middles)
    return (
        comm.py2f(),
        grows.tobytes(),
        discretisation.ends,
        approximation.order,
        approximation.thickness_points,
        approximation.thickness_rule,
        wall.bending,
        wall.energy_per_grown_volume,
        *(_kind_of_law(law) for law in (wall.energy, wall.growth_law, wall.thinning)),
        *(_kind(ratio) for ratio in (wall.thickness_ratio, wall.modulus_ratio)),
    )


def _kind_of_law(law: Law | None) -> Hashable:
    if law is None:
        return None
    return law.function, *((name, _kind(value)) for name, value in law.parameters.items())


def _kind(value: Parameter | None) -> str:
    """Return how a parameter enters the forms."""
    if value is None:
        return "none"
    if isinstance(value, tuple):
        return "following weights" if follow_tip(value) else "weights"
    return "field" if callable(value) else "number"
