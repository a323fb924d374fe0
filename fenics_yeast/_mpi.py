"""MPI, which starts quickly in a process that is not one of several ranks."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

# Set by mpirun, srun and others for each rank, and in a batch script: only settings depend on it.
_RANKS = ("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID")
ALONE = not any(name in os.environ for name in _RANKS)
# For Open MPI: no daemon that could add ranks, and only the process itself to talk to. Its search
# for the network takes a third of a second.
_NO_NETWORK = {
    "OMPI_MCA_ess_singleton_isolated": "1",
    "OMPI_MCA_btl": "self",
    "OMPI_MCA_pml": "ob1",
}


@contextmanager
def _started_alone() -> Iterator[None]:
    """Make MPI start without a network, unless this is a rank of several.

    The settings of a user, and those that processes inherit, do not change.
    """
    mine: dict[str, str] = {}
    if ALONE:
        mine = {name: value for name, value in _NO_NETWORK.items() if name not in os.environ}
    os.environ.update(mine)
    try:
        yield
    finally:
        for name in mine:
            del os.environ[name]


with _started_alone():
    from mpi4py import MPI

__all__ = ["ALONE", "MPI"]
