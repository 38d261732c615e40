"""Central cameras with a wide view: one module a kind, all used alike (`central.CentralCamera`)."""
