"""Lazy maps: chunks are computed on demand, here or on a cluster, also when one of its workers is killed."""

import json
import os
import signal
import time

import numpy as np
import pytest
from maps import near

import kinetostatics as ks
from kinetostatics.workspace import run

GRID = {"z": np.linspace(0.45, 0.65, 8), "rx": np.linspace(-0.15, 0.15, 5), "ry": np.array([-0.1, 0.0, 0.12])}


@pytest.fixture
def computed(monkeypatch):
    """Return the corners of the chunks that are computed."""
    places = []
    compute = run._chunk

    def counted(numbers, *arguments):
        places.append(tuple(int(numbers[f"number of {name}"][0]) for name in GRID))
        return compute(numbers, *arguments)

    monkeypatch.setattr(run, "_chunk", counted)
    return places


def test_only_needed_chunks_are_computed(computed):
    ds = ks.sweep("3rps", GRID, chunks={"z": 3, "ry": 2})
    assert (
        not computed
        and ds["twist"].chunks == ((3, 3, 2), (5,), (2, 1), (6,))
        and ds["status"].chunks == ((3, 3, 2), (5,), (2, 1))
    )
    assert ds["z"].values.tolist() == GRID["z"].tolist() and ds.attrs["robot_name"] == "3rps"
    piece = ds["twist"].isel(z=[0, 7], ry=0).compute(scheduler="synchronous")
    assert {place[0] for place in computed} == {0, 6} and len(computed) == 2
    near(ds.compute(scheduler="synchronous"), wanted := ks.sweep("3rps", GRID))
    assert len(computed) == 2 + 6  # once each for all variables
    np.testing.assert_allclose(piece.isel(z=1), wanted["twist"].isel(z=7, ry=0), rtol=1e-9, atol=1e-18)


def test_auto_chunks_split_a_million_poses_into_fifty():
    grid = {"z": np.linspace(0.45, 0.65, 100), "rx": np.linspace(-0.1, 0.1, 100), "ry": np.linspace(-0.1, 0.1, 100)}
    ds = ks.sweep("3rps", grid, chunks="auto")  # a million poses, of which none is computed
    sizes = [len(pieces) for pieces in ds["status"].chunks]
    assert np.prod(sizes) == 50


@pytest.mark.parametrize(
    "chunks, message",
    [({"x": 2}, "'x' is no dimension"), ({"z": 0}, "must be a number"), ({"z": 2.5}, "must be a number"), ("all", "'auto'")],
)
def test_invalid_chunks_are_refused(chunks, message):
    with pytest.raises(ks.ArgumentError, match=message):
        ks.sweep("3rps", GRID, chunks=chunks)


@pytest.mark.slow
def test_killed_cluster_worker_does_not_change_the_map():
    """Two processes, of which one is killed in mid-sweep."""
    import distributed
    import map_on_a_cluster

    with map_on_a_cluster.local_cluster() as cluster, distributed.Client(cluster) as client:
        future = map_on_a_cluster.start(client)
        killed = None
        while killed is None:
            done = {address: keys for address, keys in client.has_what().items() if len(keys) > 3}
            assert not future.done(), "too fast to be killed in mid-sweep"
            if len(done) == 2:
                address = next(iter(done))
                killed = client.run(os.getpid, workers=[address])[address]
                os.kill(killed, signal.SIGKILL)
            time.sleep(0.01)
        found = future.result(timeout=60)
        assert killed not in client.run(os.getpid).values()
    wanted = ks.sweep("3rps", {name: found[name].values for name in ("z", "rx", "ry")})
    near(found, wanted)
    assert json.loads(found.attrs["arguments"]) == json.loads(wanted.attrs["arguments"])
