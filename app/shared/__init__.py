"""What several tabs use: loaded heads, sets and pairs, jobs, limits, and the page's parts."""
