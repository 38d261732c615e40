"""Names of the shapes that rays are cast at."""

BOX, CYLINDER, SPHERE, CONE = range(4)
