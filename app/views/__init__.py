"""The tabs, one a file: answers are functions, `build` is wiring."""
