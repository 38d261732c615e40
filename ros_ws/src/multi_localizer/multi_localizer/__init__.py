"""Poses from floor shape, landmarks, teammates and stereo views."""
