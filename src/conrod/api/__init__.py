"""The functions that users call: each tells in order how its answer comes about, from scenes and files to findings.

Arguments are values: a scene by its name, as a mechanism file or as an object; numbers in SI; files as paths; models
and tables in memory. Studies return `Findings`. The command line parses its options, calls these and prints.
"""
