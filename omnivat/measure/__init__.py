"""What a head or a set is worth: gaps, accuracy in unseen domains, and what is known of the target.

Imports `head`, `encoders`, `data` and `kit`. A new gap is a module in `gaps/` and a line in its
table; it is then a name for `omnivat gaps` and `omnivat sweep`.
"""
