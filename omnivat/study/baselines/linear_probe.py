"""Linear probe: multinomial logistic regression on frozen embeddings, C chosen on the source.

Three ways to use both images: late fusion (one probe each, the mean of their probabilities), early
fusion (one probe on the concatenation) and one probe on the sum. Photo only and touch only are
probes of one modality, the same in all three.
"""

from collections.abc import Callable
from functools import partial
from hashlib import blake2b

from torch import Tensor
from torch.nn.functional import normalize

from omnivat.study.baselines.contract import Fitted, Source, joined, late
from omnivat.study.baselines.logistic import Logistic, fit_logistic

Mix = Callable[[Tensor, Tensor], Tensor]
_KEPT: dict[str, dict[str, Logistic]] = {}  # probes by a hash of the source


def fit(source: Source) -> Fitted:
    """Fit one probe on VIS and one on TAC; "fused" is the mean of their probabilities."""
    probes = _one_each(source)
    chosen: dict[str, float | str] = {}
    for name, one in probes.items():
        chosen |= {f"C of {name.upper()}": one.strength, f"scaling of {name.upper()}": one.kind}
    return Fitted(
        predict=late(lambda name, rows: probes[name].probabilities(rows)),
        chosen=chosen,
        parameters=sum(one.parameters for one in probes.values()),
    )


def _fit_mixed(source: Source, mix: Mix) -> Fitted:
    """Fit one probe on VIS and TAC mixed."""
    both = fit_logistic(source, lambda pairs: mix(pairs.vis, pairs.tac))
    one_each = fit(source).predict

    def predict(seen: Tensor, touched: Tensor) -> dict[str, Tensor]:
        return one_each(seen, touched) | {"fused": both.probabilities(mix(seen, touched))}

    return Fitted(
        predict=predict,
        features=lambda seen, touched: {**joined(seen, touched), "pair": mix(seen, touched)},
        chosen={"C": both.strength, "scaling": both.kind},
        parameters=both.parameters,
    )


def _one_each(source: Source) -> dict[str, Logistic]:
    """Return a probe of VIS and a probe of TAC; the probes of the last two sources are cached.

    The three methods share them.
    """
    digest = blake2b(str((source.seed, source.noise, source.objects, source.classes)).encode())
    for rows in (source.vis, source.tac, source.labels):
        digest.update(rows.numpy().tobytes())
    key = digest.hexdigest()
    if key not in _KEPT:
        while len(_KEPT) > 1:
            _KEPT.pop(next(iter(_KEPT)))
        vis, tac = (
            fit_logistic(source, lambda pairs: pairs.vis),
            fit_logistic(source, lambda pairs: pairs.tac),
        )
        _KEPT[key] = {"vis": vis, "tac": tac}
    return _KEPT[key]


# Of unit vectors, so that both modalities have equal weight.
fit_concatenated = partial(_fit_mixed, mix=lambda vis, tac: joined(vis, tac)["pair"])
fit_sum = partial(_fit_mixed, mix=lambda vis, tac: normalize(vis, dim=-1) + normalize(tac, dim=-1))
