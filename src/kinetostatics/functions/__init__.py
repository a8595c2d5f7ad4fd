"""Functions of one robot: from coordinates, load and gravity to what people ask of a pose, with their derivatives."""
