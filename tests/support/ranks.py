"""MPI ranks that tests start, several on one machine, and those that tests run under."""

import os
from typing import Any

# Set in what mpirun starts, and in a process that has initialised MPI without it.
_LAUNCHED = ("OMPI_", "PMIX_", "PMI_", "PRTE_")
_RANKS = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_btl": "^tcp,ofi",  # through memory, whatever the network of this machine
    "OMPI_MCA_hwloc_base_binding_policy": "none",  # else all runs wait for the first cores
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",  # PRTE: Open MPI 5
    "PRTE_MCA_hwloc_default_binding_policy": "none",
    "OMP_NUM_THREADS": "1",
}


def environment() -> dict[str, str]:
    """Environment of a process that belongs to no MPI run yet and may start one."""
    outside = {k: v for k, v in os.environ.items() if not k.startswith(_LAUNCHED)}
    return outside | _RANKS


def mpirun(ranks: int) -> list[str]:
    """Start of a command that runs on a number of ranks; without mpirun on a single one."""
    return ["mpirun", "-n", str(ranks)] if ranks > 1 else []


def world() -> Any:
    """Communicator of the ranks that the tests run on, None if they were started without mpirun.

    Only then MPI is loaded, as the package does it: most tests of scenes need none.
    """
    if not {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"} & os.environ.keys():
        return None
    from fenics_yeast import _dolfinx as dx

    return dx.MPI.COMM_WORLD
