#!/usr/bin/env bash
# Measure the method on the examples: protocol and ablations, into docs/.
# bash examples/measure.sh [FOLDER FOR THE RECORDS]   (about an hour and a half on one core; goes on where it stopped)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/measured}
light=(--embeddings examples/simulated.safetensors --seeds 0,1,2 --set width=64 --set epochs=60)
methods=omnivat,nearest_mean,linear_probe,linear_probe_concat,baseline
python -m omnivat protocol "${light[@]}" --out "$out/protocol" --methods "$methods"
if [ ! -f "$out/full/runs.jsonl" ]; then # the other methods are the same; the head is run anew
    mkdir -p "$out/full"
    grep -v '"method": "omnivat"' "$out/protocol/runs.jsonl" >"$out/full/runs.jsonl"
fi
python -m omnivat protocol --embeddings examples/simulated.safetensors --seeds 0,1,2 \
    --out "$out/full" --methods omnivat --set width=512 --set epochs=60
python -m omnivat ablate "${light[@]}" --out "$out/ablations" \
    --only components,generation,class_token,modalities,order,projection,fixed_order,levels,expansion,balance
python -m omnivat ablate --embeddings examples/simulated.safetensors --seeds 0,1,2 \
    --out "$out/ablations_full" --only components,order --set width=512 --set epochs=60
cp "$out/protocol/report.md" docs/benchmarks/protocol.md
cp "$out/full/report.md" docs/benchmarks/protocol_full.md
cp "$out/ablations/ablations.md" docs/benchmarks/ablations.md
cp "$out"/ablations/*.svg docs/benchmarks/
grep -v '^!\[' "$out/ablations_full/ablations.md" >docs/benchmarks/ablations_full.md
cp "$out/ablations/fixed_order.json" examples/retrained.json
cp "$out/protocol/runs.jsonl" docs/benchmarks/protocol.jsonl
grep '"method": "omnivat"' "$out/full/runs.jsonl" >docs/benchmarks/protocol_full.jsonl
cp "$out/ablations/runs.jsonl" docs/benchmarks/ablations.jsonl
cp "$out/ablations_full/runs.jsonl" docs/benchmarks/ablations_full.jsonl
