"""Results that are the same to the last digit."""

import numpy as np

from fenics_yeast.simulation import Profiles, Result


def same(one: Result, other: Result) -> None:
    """All but the time that it took is the same, to the last digit."""
    assert one.history.rows == other.history.rows
    assert (one.status, one.message) == (other.status, other.message)
    assert one.newton_iterations == other.newton_iterations
    assert one.rejected_steps == other.rejected_steps
    same_profiles(one.profiles, other.profiles)


def same_profiles(some: Profiles, others: Profiles) -> None:
    ours, theirs = some.arrays(), others.arrays()
    assert ours.keys() == theirs.keys()
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours)
