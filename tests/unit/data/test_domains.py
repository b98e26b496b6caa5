"""The eight domains and their names."""

import pytest

from omnivat.data.domains import DOMAINS, is_simulated, paper_name, require_domain_names, simulated
from omnivat.kit.errors import DataError


def test_there_are_eight_domains_and_tacquad_has_no_ceramic():
    assert len(DOMAINS) == 8
    assert [name for name, domain in DOMAINS.items() if not domain.ceramic] == [
        "TQ-DIGIT", "TQ-GelMini", "TQ-DuraGel", "TQ-T3D",
    ]  # fmt: skip


def test_a_simulated_name_says_so_and_leads_back_to_the_papers():
    for name in DOMAINS:
        assert is_simulated(simulated(name))
        assert paper_name(simulated(name)) == name
        assert not is_simulated(name)


def test_a_domain_may_not_carry_the_name_of_the_total():
    require_domain_names(["here", "All"])
    with pytest.raises(DataError, match="A domain is called 'all'.*rename the domain"):
        require_domain_names(["here", "all"])
