"""Explore: facts of the set, other heads, nodes of the tree, and a pair's place on the map."""
