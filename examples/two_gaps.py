"""Does p close the two gaps? The figures of the page's chapter *p and the gaps*, and a pair's way.

python -m examples.two_gaps
"""

import torch

from omnivat import (
    EXAMPLES,
    default_embeddings,
    default_head,
    journey,
    load_embeddings,
    load_head,
    map_stops,
    read_frames,
)

PAIR = 1200
STEPS = {"raw": "embedding", "frft": "transform", "relu": "ReLU", "f_bar": "attention"}
STEPS |= {"f_hat": "tree"}

head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
frames = read_frames(EXAMPLES / "frames.bin")  # of this head and these pairs, at 102 stops of p

print(f"{len(embeddings)} pairs, simulated: {embeddings.header.simulated}")
print(f"{'over all p':<14}" + "".join(f"{name:<16}" for name in STEPS.values()))
for gap in ("modality_gap", "domain_gap"):
    curves = [frames.curves[f"{gap}/{step}"] for step in STEPS]
    print(f"{gap:<14}" + "".join(f"{min(c):.3f} to {max(c):<7.3f}" for c in curves))

stops = map_stops(head, embeddings, frames, most=5)
vis, tac = (
    torch.from_numpy(rows[PAIR : PAIR + 1].astype("float32"))
    for rows in (embeddings.vis, embeddings.tac)
)
found = journey(head, stops, vis, tac)
classes = head.settings.classes
print(f"\nPair {PAIR}, {embeddings.header.classes[embeddings.label[PAIR]]}, on the UMAP of F-hat")
print(f"{'p':<6}{'predicted':<15}{'photo':<16}{'touch':<16}its seven nodes alone")
for at, p in enumerate(found.orders):
    share, best = found.readings["fused"][at, 0].max(0)
    vis, tac = (
        "({:.2f}, {:.2f})".format(*found.places["umap"][m][at, 0].tolist()) for m in ("vis", "tac")
    )
    nodes = [classes[k] for k in found.node_probabilities[at, 0].argmax(-1)]
    said = f"{classes[best]} {share:.0%}"
    print(f"{p:<6.2f}{said:<15}{vis:<16}{tac:<16}{', '.join(nodes)}")
