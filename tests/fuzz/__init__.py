"""A seeded, bounded mutation fuzzer of every reader and every command: ``python -m tests.fuzz --seconds 60``.

A corpus of small files is made by the workbench's own commands; each case changes one file, or one value of a command
line, and runs a command in a process of its own kind: limited in time and memory, in a folder that is looked at
afterwards. What it ever found is replayed by `test_cases.py`.
"""
