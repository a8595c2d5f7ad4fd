"""Reports as data (sections of tables, facts and sentences) and their renderings: text, colour, HTML, plain values."""
