"""Lets drawn examples take their time: kernels compile on the first call, machines are busy."""

from hypothesis import settings

settings.register_profile("busy", deadline=None)
settings.load_profile("busy")
