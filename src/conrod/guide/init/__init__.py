"""A project begun: a mechanism file, a test and a workflow, ready to run."""
