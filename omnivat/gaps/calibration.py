"""Expected calibration error: how far confidence is from accuracy."""

from torch import Tensor

from omnivat.shapes import require_shapes


def ece(probabilities: Tensor, labels: Tensor, *, bins: int = 15) -> Tensor:
    """Mean over pairs of |accuracy - confidence| of the bin that a pair's confidence falls in.

    probabilities  (N, K) rows that add up to 1; confidence is a row's largest entry
    labels         (N,) class indices
    bins           equal steps of confidence from 0 to 1; a border belongs to the lower bin
    return         () in [0, 1]; NaN for no pairs

    Source: Guo et al., ICML 2017.
    """
    require_shapes(probabilities=(probabilities, "N K"), labels=(labels, "N"))
    if not len(labels):
        return probabilities.new_tensor(float("nan"))
    confidence, answer = probabilities.max(1)
    place = ((confidence * bins).ceil().long() - 1).clamp(0, bins - 1)
    surplus = (answer == labels).to(confidence.dtype) - confidence
    by_bin = confidence.new_zeros(bins).index_add_(0, place, surplus)
    return by_bin.abs().sum() / len(labels)
