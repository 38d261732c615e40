"""Installs the package where `ros2 run` finds it; setup.cfg says all of it."""

from setuptools import setup

setup()
