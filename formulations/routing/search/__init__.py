"""Min-max route search: ruin-and-recreate and the memetic search, as small numba kernels on flat arrays."""
