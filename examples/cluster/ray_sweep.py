"""A sweep on a Ray cluster: each task computes one shard, then all are merged.

    pip install ray
    python examples/cluster/ray_sweep.py studies/formats.toml out/formats --shards 4

Without --address Ray is started on this machine's cores. On several machines the output must be a
folder that all of them see. A worker that dies costs the points in flight: its shard is tried
again and goes on where it was.
"""

import argparse
import os
import subprocess
import time
from pathlib import Path

import ray


@ray.remote(num_cpus=1, max_retries=2, retry_exceptions=True)
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
    arguments.add_argument("study", type=Path)
    arguments.add_argument("output", type=Path)
    arguments.add_argument("--shards", type=int, default=8)
    arguments.add_argument("--address", help="address of a running cluster")
    arguments.add_argument("--program", default="amacrine", help="where amacrine is")
    given = arguments.parse_args()

    # Tasks run in a folder of their own.
    study, output = given.study.resolve(), given.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    ray.init(address=given.address, include_dashboard=False, log_to_driver=False)
    tasks = [
        shard.remote(given.program, str(study), str(output), index, given.shards)
        for index in range(given.shards)
    ]
    while tasks:
        done, tasks = ray.wait(tasks)
        print(ray.get(done[0]), end="")
    ray.shutdown()
    folders = [f"{output}/shard-{index}" for index in range(given.shards)]
    subprocess.run([given.program, "merge", *folders, "--output", f"{output}/all"], check=True)


if __name__ == "__main__":
    main()
