"""The tabs, one in each file: results are functions. A `build` lays out more than the tab's
component.
"""

VIEWS = ("explore", "pair", "train")  # in their order on the page
