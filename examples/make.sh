#!/usr/bin/env bash
# Make everything in this folder again: pairs, embeddings, thumbnails, head and frames.
# bash examples/make.sh [FOLDER FOR THE FULL SET]   (about an hour on two cores)
# The first step needs Mitsuba, taxim and jax: python -m pip install ".[simulate]"
set -euo pipefail
cd "$(dirname "$0")/.."
full=${1:-build/simulated}
python -m omnivat simulate --out "$full" --examples examples/pairs
python -m omnivat embed "$full" --out examples/simulated.safetensors --dtype float16
python -m omnivat thumbnails "$full" --embeddings examples/simulated.safetensors --tile 56
python -m omnivat train --embeddings examples/simulated.safetensors --source TAG-sim \
    --out examples/head --repeat 1,2 --set width=64 --set epochs=60
python -m omnivat sweep --out examples/frames.bin
