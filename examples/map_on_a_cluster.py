"""A lazy map computed by the workers of a dask cluster; what a worker has not finished when it dies is computed by another.

python examples/map_on_a_cluster.py
"""

import numpy as np
from distributed import Client, Future, LocalCluster

import kinetostatics as ks


def start(client: Client) -> Future:
    """Return the future of a map of the 3RPS; each worker computes one height z after the other."""
    grid = {"z": np.linspace(0.45, 0.65, 61), "rx": np.linspace(-0.15, 0.15, 8), "ry": np.linspace(-0.1, 0.1, 10)}
    return client.compute(ks.sweep("3rps", grid, chunks={"z": 1}))


def local_cluster() -> LocalCluster:
    """Return two processes on this machine; ``dask_jobqueue.SLURMCluster`` and others start workers elsewhere."""
    return LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)


if __name__ == "__main__":
    with local_cluster() as cluster, Client(cluster) as client:
        print(ks.indices.worst(start(client).result(), "linear_sag"))
