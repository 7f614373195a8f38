"""Laws are tried on the same drawn cases every time; `--hypothesis-profile=explore` draws fresh ones."""

from hypothesis import settings

settings.register_profile("explore", settings())
settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")
