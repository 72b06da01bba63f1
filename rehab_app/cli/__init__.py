"""The command line: one command per verb, refusals turned into one sentence in one place."""
