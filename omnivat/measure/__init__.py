"""What a head or a set is worth: gaps, accuracy in unseen domains, and what is known of the target.

Imports `head`, `data` and `kit`. A new gap is a module in `gaps/` and a line in its
table; it is then in `omnivat gaps` and in the curves of every sweep.
"""
