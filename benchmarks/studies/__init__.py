"""Studies: what was measured once to answer a question, and can be measured again."""
