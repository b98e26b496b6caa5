#!/usr/bin/env bash
# Make everything in this folder again: pairs, embeddings, thumbnails, head and frames.
# bash examples/make.sh [FOLDER FOR THE FULL SET]   (about an hour on two cores)
# The first step needs Mitsuba, taxim and jax: python -m pip install -r simulator/requirements.txt
set -euo pipefail
cd "$(dirname "$0")/.."
full=${1:-build/simulated}
python -m simulator set --out "$full" --examples examples/pairs
python -m omnivat embed "$full" --out examples/simulated.safetensors --dtype float16
python -m benchmarks.relief "$full"  # touches by relief, for the table
python -m omnivat thumbnails "$full" --embeddings examples/simulated.safetensors --tile 56
python -m omnivat train --embeddings examples/simulated.safetensors --source TAG-sim \
    --out examples/head --repeat 1,2 --set width=64 --set noise=4 --set shift=1 --set epochs=120
python -m omnivat train --embeddings examples/simulated.safetensors --source all --out examples/own
python -m omnivat sweep --out examples/frames.bin
python -m omnivat evaluate --ladder
python -m omnivat sweep --retrained 21 --seeds 0,1 --out examples/retrained.bin
# One head for every order; what familiarity needs lies in the other head's folder.
python -m omnivat train --embeddings examples/simulated.safetensors --source TAG-sim \
    --out examples/every --no-calibration --set width=64 --set epochs=750 --set batch=64 \
    --set lr=0.1 --set noise=2 --set order_draw=true \
    --set order_teachers=4
rm examples/every/familiarity.safetensors
python -m omnivat sweep --head examples/every --stops 11 --out examples/every.bin
# Twins: one press by every sensor. The touches take ten minutes; the shipped set stopped after 60 objects' photographs.
python -m simulator twins --out build/twins/pictures
# KEPT and FILLED: embeddings of the set above with the printed dots of its touches kept and filled (omnivat/data/dots.py).
if [ -n "${KEPT:-}" ] && [ -n "${FILLED:-}" ]; then
    python -m benchmarks.twins --learn "$KEPT" "$FILLED" --pack build/twins/pictures
    python -m benchmarks.twins --learn "$KEPT" "$FILLED" --page build/twins/pictures
fi
