"""Tables, intervals and plots, rebuilt from records of runs; nothing here runs anything."""
