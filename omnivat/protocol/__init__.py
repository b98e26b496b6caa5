"""The paper's experiment: learn from one domain, answer on the others, for methods and seeds.

settings.py  the eight source and target settings
methods.py   what is compared
run.py       one method, one source, one seed -> one record
records.py   records as JSON lines, with a key each, so that runs resume
engine.py    runs one after another, in processes side by side, or through ray
"""
