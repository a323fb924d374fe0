"""The environment in which tests start several MPI ranks on one machine."""

RANKS = {
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
