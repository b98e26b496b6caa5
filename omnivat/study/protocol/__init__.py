"""The paper's experiment: train on one domain, test on the others, for methods and seeds.

settings.py  the eight source and target settings
methods.py   what is compared
run.py       one method, one source, one seed -> one record
records.py   records as JSON lines with keys, so that runs resume
engine.py    runs in sequence, or in parallel processes
"""
