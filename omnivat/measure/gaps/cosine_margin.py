"""The earlier place of three margins of `omnivat.measure.gaps.sums`, for one version."""

from omnivat.measure.gaps.sums import cosine_margin as cosine_margin
from omnivat.measure.gaps.sums import cross_domain_margin as cross_domain_margin
from omnivat.measure.gaps.sums import cross_modal_margin as cross_modal_margin
