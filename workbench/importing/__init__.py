"""Importing: results of others' programs as foreign runs of a store."""
