#!/usr/bin/env bash
# Measure the methods on the examples: the one table of results, and the ablations of the head.
# bash examples/measure.sh [FOLDER FOR THE RECORDS] [PROCESSES]   (goes on where it stopped)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/measured}
export OMP_NUM_THREADS=1
table=(python -m benchmarks.table --out "$out/table.jsonl")
"${table[@]}" --seeds 0,1,2,3,4
"${table[@]}" --seeds 0 --methods linear_maps@10,omnivat@10,linear_maps@20,omnivat@20
"${table[@]}" --pack
by_relief=(python -m benchmarks.table --relief --out "$out/relief.jsonl" --seeds 0)
"${by_relief[@]}" --pack
python -m benchmarks.table_text
python -m benchmarks.recompute
python -m omnivat ablate --embeddings examples/simulated.safetensors --seeds 0,1,2 --jobs "${2:-2}" \
    --set epochs=30 --set width=64 --out "$out/ablations" \
    --only expansion,details,generation,class_token,modalities,levels,balance,order,fixed_order
