"""Small tools of every wing: errors, files, tables, settings, threads, devices, seeds, progress.

Imports nothing of the project; every wing may import it. A new tool is a module here that no wing
owns: it knows nothing of pairs, heads or maps.
"""
