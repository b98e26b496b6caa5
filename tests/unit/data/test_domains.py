"""The eight domains and their names."""

from omnivat.data.domains import DOMAINS, is_simulated, paper_name, simulated


def test_a_simulated_name_says_so_and_leads_back_to_the_papers():
    for name in DOMAINS:
        assert is_simulated(simulated(name))
        assert paper_name(simulated(name)) == name
        assert not is_simulated(name)
