"""A sweep on a Dask cluster: each task computes one shard, then all are merged.

    pip install "dask[distributed]"
    python examples/cluster/dask_sweep.py studies/formats.toml out/formats --shards 4

Without --scheduler a cluster of this machine's cores is started. On several machines the
output must be a folder that all of them see. A worker that dies costs the points in flight:
its shard is tried again and goes on where it was.
"""

import argparse
import os
import subprocess
import time
from pathlib import Path

from dask.distributed import Client, LocalCluster, as_completed


def shard(program, study, output, index, count):
    """Computes one shard; what the program said. A worker that dies leaves its program running, which
    is waited for."""
    command = [program, "sweep", study, "--output", f"{output}/shard-{index}"]
    command += ["--shard", f"{index}/{count}", "--jobs", "1", "--json"]
    # Its messages in plain lines.
    plain = {**os.environ, "NO_GRAPHICS": "1"}
    while True:
        done = subprocess.run(command, capture_output=True, text=True, env=plain)
        if "in use by another amacrine" not in done.stderr:
            break
        time.sleep(5)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return done.stdout


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("study")
    arguments.add_argument("output", type=Path)
    arguments.add_argument("--shards", type=int, default=8)
    arguments.add_argument("--scheduler", help="address of a running cluster")
    arguments.add_argument("--program", default="amacrine", help="where amacrine is")
    given = arguments.parse_args()

    given.output.mkdir(parents=True, exist_ok=True)
    cluster = None if given.scheduler else LocalCluster(threads_per_worker=1, dashboard_address=None)
    with Client(given.scheduler or cluster) as client:
        tasks = [
            client.submit(
                shard, given.program, given.study, str(given.output), index, given.shards,
                retries=2, pure=False,
            )
            for index in range(given.shards)
        ]
        for task in as_completed(tasks):
            print(task.result(), end="")
    if cluster:
        cluster.close()
    folders = [f"{given.output}/shard-{index}" for index in range(given.shards)]
    subprocess.run([given.program, "merge", *folders, "--output", f"{given.output}/all"], check=True)


if __name__ == "__main__":
    main()
