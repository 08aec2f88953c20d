"""The native solver: plain loops, compiled by Numba. The way in is :func:`hqp.kernels.solver.solve`."""
