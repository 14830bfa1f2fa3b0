#!/usr/bin/env bash
# A sweep as a SLURM array job: each task computes one shard in a folder of its own.
#
#   sbatch --array=0-15 examples/cluster/slurm.sh studies/thousand.toml /scratch/me/thousand
#
# and when all are done (or some were killed: submit the same line again, it goes on):
#
#   amacrine merge /scratch/me/thousand/shard-* --output /scratch/me/thousand/all
#
# The array must count from 0. AMACRINE names the program where it is not on the path.
#SBATCH --job-name=amacrine-sweep
#SBATCH --cpus-per-task=4
#SBATCH --mem-per-cpu=2G
#SBATCH --time=01:00:00
set -euo pipefail

study=${1:?the study file}
output=${2:?the folder for all shards}
index=${SLURM_ARRAY_TASK_ID:?run this with sbatch --array=0-N}
count=${SLURM_ARRAY_TASK_COUNT:?run this with sbatch --array=0-N}

mkdir -p "$output"
exec "${AMACRINE:-amacrine}" sweep "$study" \
  --output "$output/shard-$index" \
  --shard "$index/$count" \
  --jobs "${SLURM_CPUS_PER_TASK:-1}"
