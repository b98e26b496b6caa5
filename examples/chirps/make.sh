#!/usr/bin/env bash
# Make everything in this folder again: pictures, embeddings, thumbnails, heads and frames.
# bash examples/chirps/make.sh [FOLDER FOR THE FULL SET]   (about ten minutes on two cores)
set -euo pipefail
cd "$(dirname "$0")/../.."
full=${1:-build/chirps}
here=examples/chirps
set="$here/chirps.safetensors"
settings="--set width=64 --set theta_init=signed --set lang=false"
python -m simulator chirps --out "$full" --examples "$here/pairs"
python -m omnivat embed "$full" --encoder strip --no-flips --out "$set"
python -m omnivat thumbnails "$full" --embeddings "$set" --tile 32
# shellcheck disable=SC2086
python -m omnivat train --embeddings "$set" --source "Chirps A-sim" --out "$here/head" \
    $settings --set epochs=40 --set order_search=true
# shellcheck disable=SC2086
python -m omnivat train --embeddings "$set" --source "Chirps A-sim" --out "$here/every" \
    $settings --no-calibration --set epochs=600 --set batch=32 --set lr=0.1 \
    --set order_draw=true
rm "$here/every/familiarity.safetensors"
# Fifty-one stops and the learned order: a set of a few MB
orders=$(python - "$here/head" <<'END'
import sys
from omnivat.head.checkpoint import load_head
from omnivat.maps.frames.records import with_learned
print(*with_learned([k / 50 for k in range(51)], load_head(sys.argv[1]).model.order), sep=",")
END
)
python -m omnivat sweep --head "$here/head" --embeddings "$set" --orders "$orders" --out "$here/frames.bin"
python -m omnivat sweep --head "$here/every" --embeddings "$set" --stops 21 --out "$here/every.bin"
python -m omnivat sweep --head "$here/head" --embeddings "$set" --retrained 21 --seeds 0 --out "$here/retrained.bin"
