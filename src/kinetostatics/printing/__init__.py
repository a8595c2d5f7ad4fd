"""Text for people: numbers with units, tables, short reprs, signs of life."""
