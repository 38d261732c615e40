"""The live view in a browser: what is sent, how it is served, and the page."""
