"""One file per experiment of a paper or benchmark."""
