"""Train here: settings, one training at a time, its progress, and the finished head.

`tab` lays out Gradio's components, `runs` trains and queues, `plan` checks settings, `words` states
results.
"""
