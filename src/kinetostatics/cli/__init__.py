"""The commands of ``kinetostatics``, and what they share: their table, inputs and output."""
