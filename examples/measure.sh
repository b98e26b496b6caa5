#!/usr/bin/env bash
# Measure the method on the examples: protocol and ablations, into docs/.
# bash examples/measure.sh [FOLDER FOR THE RECORDS]   (about an hour on one core; goes on where it stopped)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/measured}
light=(--embeddings examples/simulated.safetensors --seeds 0,1,2 --set width=64 --set epochs=60)
methods=omnivat,nearest_mean,linear_probe,linear_probe_concat,baseline
python -m omnivat protocol "${light[@]}" --out "$out/protocol" --methods "$methods"
python -m omnivat ablate "${light[@]}" --out "$out/ablations" \
    --only components,generation,class_token,modalities,order,projection,fixed_order
cp "$out/protocol/report.md" docs/benchmarks/protocol.md
cp "$out/ablations/ablations.md" docs/benchmarks/ablations.md
cp "$out"/ablations/*.svg docs/benchmarks/
cp "$out/ablations/fixed_order.json" examples/retrained.json
cp "$out/protocol/runs.jsonl" docs/benchmarks/protocol.jsonl
