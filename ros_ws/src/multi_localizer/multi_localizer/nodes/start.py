"""The executables that are nodes; each imports its node once a signal can end it cleanly."""
