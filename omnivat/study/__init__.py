"""The experiments and what they say: comparison methods, the paper's protocol, reports, trials,
a head of all domains, a head at every order.

Imports every other wing but the command line. A new method is a module in `baselines/` and a line
in its table; it is then in `omnivat protocol` and in every report.
"""
