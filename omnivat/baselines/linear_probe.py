"""Linear probe: multinomial logistic regression on frozen embeddings, C chosen on the source."""

import torch
from torch import Tensor

from omnivat.baselines.contract import Fitted, Source, fused
from omnivat.baselines.logistic import fit_logistic


def fit(source: Source) -> Fitted:
    """Fit one probe on VIS and one on TAC; "fused" is the mean of their probabilities."""
    vis = fit_logistic(source, lambda pairs: pairs.vis)
    tac = fit_logistic(source, lambda pairs: pairs.tac)

    def predict(seen: Tensor, touched: Tensor) -> dict[str, Tensor]:
        return fused({"vis": vis.probabilities(seen), "tac": tac.probabilities(touched)})

    return Fitted(
        predict=predict,
        chosen={
            "C of VIS": vis.strength,
            "scaling of VIS": vis.kind,
            "C of TAC": tac.strength,
            "scaling of TAC": tac.kind,
        },
        parameters=vis.parameters + tac.parameters,
    )


def fit_concatenated(source: Source) -> Fitted:
    """Fit one probe on VIS and TAC side by side."""
    both = fit_logistic(source, lambda pairs: _side_by_side(pairs.vis, pairs.tac))

    def predict(seen: Tensor, touched: Tensor) -> dict[str, Tensor]:
        return {"fused": both.probabilities(_side_by_side(seen, touched))}

    return Fitted(
        predict=predict,
        chosen={"C": both.strength, "scaling": both.kind},
        parameters=both.parameters,
    )


def _side_by_side(vis: Tensor, tac: Tensor) -> Tensor:
    """Join unit vectors, so that neither modality counts more for its length."""
    unit = torch.nn.functional.normalize
    return torch.cat((unit(vis, dim=-1), unit(tac, dim=-1)), dim=-1)
