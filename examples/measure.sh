#!/usr/bin/env bash
# Measure the method on the examples: every table of the protocol, ablations and cost, into docs/.
# bash examples/measure.sh [FOLDER FOR THE RECORDS] [PROCESSES]   (goes on where it stopped)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/measured}
export OMP_NUM_THREADS=1
common=(--embeddings examples/simulated.safetensors --seeds 0,1,2 --jobs "${2:-2}" --set epochs=30)
full=(python -m omnivat protocol "${common[@]}" --set width=512 --calibrate --out "$out/full")
light=(python -m omnivat protocol "${common[@]}" --set width=64 --calibrate --out "$out/light")
ablate=(python -m omnivat ablate "${common[@]}" --set width=64 --out "$out/ablations")
choice=(--candidate "" --candidate lang=false)

# Every method read from photo, touch and both, all eight sources. Settings, temperatures and fusion are
# chosen for each source from its own held-out objects; the head chooses with LANG or without.
"${full[@]}" --methods nearest_mean
"${full[@]}" --methods omnivat "${choice[@]}"
"${full[@]}" --methods linear_probe,linear_probe_concat,dtg_alone,cosine_head,baseline,erm_mlp,mffa_alone
"${full[@]}" --methods linear_probe_sum,ldc_icd,vt_cmc_head,zero_shot,promptstyler
# One thing switched off at a time.
"${full[@]}" --methods omnivat_no_lang,omnivat_no_nod,omnivat_no_mma,omnivat_p0
# The light head; the baselines do not depend on its width.
if [ ! -f "$out/light/runs.jsonl" ]; then
    mkdir -p "$out/light"
    grep -v '"base": "omnivat"' "$out/full/runs.jsonl" >"$out/light/runs.jsonl"
fi
"${light[@]}" --methods omnivat "${choice[@]}"
# Noise on the embeddings, and training as long without it; then the evidence from the source alone.
longer=(--set epochs=120)
"${light[@]}" "${longer[@]}" --set noise=2 --out "$out/noise" --methods omnivat,dtg_alone
"${light[@]}" "${longer[@]}" --out "$out/long" --methods omnivat
evidence=(python -m omnivat protocol "${common[@]}" --seeds 0 --folds 3 --set width=64 --methods omnivat)
"${evidence[@]}" --out "$out/evidence"
"${evidence[@]}" "${longer[@]}" --out "$out/evidence_long"
"${evidence[@]}" "${longer[@]}" --set noise=2 --out "$out/evidence_noise"
# Ablations of the light head on the sources of the paper's tables.
"${ablate[@]}" --only expansion,details,generation,class_token,modalities,levels,balance,order,fixed_order
# What is known about the target, rung by rung.
python -m benchmarks.ladder --out "$out/ladder.jsonl" --pack examples/records/ladder.jsonl.gz
python -m benchmarks.ladder_table
python -m benchmarks.ladder_check
# The same budget on two further sets, drawn with other seeds (a quarter of an hour each to draw; needs Mitsuba).
sets=(python -m benchmarks.ladder_sets --out "$out/ladder_sets.jsonl")
for seed in 1 2; do
    python -m omnivat simulate --out "$out/set$seed" --seed "$seed" --pairs-per-class 30
    python -m omnivat embed "$out/set$seed" --out "$out/set$seed.safetensors" --dtype float16
    "${sets[@]}" --embeddings "$out/set$seed.safetensors" --name "$seed"
done
"${sets[@]}" --embeddings examples/simulated.safetensors --name 0 --members 3,4
"${sets[@]}" --embeddings examples/simulated.safetensors --name 0 --members 1,2 --methods dtg_recipe \
    --pack docs/benchmarks/ladder_sets.jsonl.gz
python -m benchmarks.ladder_sets_table
python -m benchmarks.profile_step
python -m benchmarks.cost
cat "$out/noise/runs.jsonl" "$out/long/runs.jsonl" | gzip -9n >docs/benchmarks/noise.jsonl.gz
python -m benchmarks.noise

for width in full light; do
    name=protocol$([ "$width" = full ] && echo _full || true)
    cp "$out/$width/report.md" "docs/benchmarks/$name.md"
done
gzip -9nc "$out/full/runs.jsonl" >examples/records/protocol_full.jsonl.gz
grep '"base": "omnivat"' "$out/light/runs.jsonl" | gzip -9n >examples/records/protocol.jsonl.gz
cp "$out/ablations/ablations.md" "$out"/ablations/*.svg docs/benchmarks/
gzip -9nc "$out/ablations/runs.jsonl" >docs/benchmarks/ablations.jsonl.gz
