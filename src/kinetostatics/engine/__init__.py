"""The statics recorded once per structure of a robot and compiled: the same functions, without Python in between."""
