"""The earlier place of three margins of `omnivat.gaps.sums`, for one version."""

from omnivat.gaps.sums import cosine_margin as cosine_margin
from omnivat.gaps.sums import cross_domain_margin as cross_domain_margin
from omnivat.gaps.sums import cross_modal_margin as cross_modal_margin
