"""People: how they look to sensors, walk, notice a robot and step aside; recorded people too."""
