"""The tabs, one in each file: results are functions, `build` is layout."""

VIEWS = ("explore", "pair", "train", "tree", "compare", "data")  # in their order on the page
