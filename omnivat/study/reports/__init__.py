"""Tables, intervals and plots from records of runs; nothing is run here."""
