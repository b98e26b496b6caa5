"""What is left if each domain loses its own mean: maps of the touches' raw embedding, before and after."""

import json
from hashlib import blake2b
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from omnivat.data.arrays import copied, walked
from omnivat.data.packing import packed
from omnivat.data.store import Embeddings
from omnivat.kit.files import write_json
from omnivat.maps.frames.builder import next_map
from omnivat.maps.frames.records import quantised
from omnivat.maps.projection import pca
from omnivat.maps.projection.quality import trust
from omnivat.measure.gaps.sums import domain_gap
from omnivat.measure.gaps.unit import unit


def centred(rows: Tensor, domain: Tensor) -> Tensor:
    """Return rows (N, D) minus the mean of their domain, plus the mean of all rows.

    domain  (N,) index
    """
    moved = rows.clone()
    for name in domain.unique():
        moved[domain == name] -= rows[domain == name].mean(0) - rows.mean(0)
    return moved


def centred_reply(embeddings: Embeddings, method: str, *, seed: int = 0) -> dict[str, Any]:
    """Return a map of the touches in two frames by "pca" or "umap", and the curve of their domain gap, for a browser.

    return  {"points": packed (2, N, 2), "bounds", "trust": [2], "curves": "domain_gap/raw" -> [as it comes, centred]}

    Frame 0 shows the unit rows as they come, frame 1 with each domain centred. PCA has one basis for both frames, so
    that a domain moves by its offset. The two UMAPs are independent: one that starts from the other keeps its islands.
    A gap is None for one domain.
    """
    rows = unit(torch.from_numpy(copied(embeddings.tac)))
    domain = torch.as_tensor(embeddings.domain[:])
    states = [rows, centred(rows, domain)]
    if method == "pca":
        basis = pca.basis(torch.cat(states))
        flats = [basis.place(state) for state in states]
    else:
        flats = [next_map(method, state, None, seed=seed) for state in states]
    scores = tuple(trust(state, flat) for state, flat in zip(states, flats, strict=True))
    gaps = [domain_gap(state, domain) for state in states]
    known = [float(gap) if gap.isfinite() else None for gap in gaps]
    made = quantised([flat.double().numpy() for flat in flats], (0, 1), scores)
    return {
        "points": packed(made.points.ravel(), "u2"),
        "bounds": [list(made.low), list(made.high)],
        "trust": list(made.trust),
        "curves": {"domain_gap/raw": known},
    }


def centred_file(embeddings: Path) -> Path:
    """Return the path of the centred maps of an embeddings file, next to the file."""
    return embeddings.with_suffix(".centred.json")


def write_centred(path: Path, embeddings: Embeddings) -> Path:
    """Write both maps of the embeddings at `path` next to them, so that the page need not compute them."""
    made = {method: centred_reply(embeddings, method) for method in ("pca", "umap")}
    write_json(centred_file(path), {"of": _content(embeddings), **made})
    return centred_file(path)


def kept_reply(path: Path, embeddings: Embeddings, method: str) -> dict[str, Any] | None:
    """Return the reply that a file next to the embeddings has; None without one of exactly these."""
    try:
        kept = json.loads(centred_file(path).read_bytes())
        reply: dict[str, Any] = kept[method]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return reply if kept.get("of") == _content(embeddings) else None


def _content(embeddings: Embeddings) -> str:
    """Return a hash of the touches and their domains."""
    content = blake2b(digest_size=8)
    for part in (*walked(embeddings.tac), embeddings.domain[:]):
        content.update(part.tobytes())
    return content.hexdigest()
