"""The tabs, one a file: answers are functions, `build` is wiring."""

VIEWS = ("explore", "pair", "train", "tree", "compare", "data")  # in their order on the page
