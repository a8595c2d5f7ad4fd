"""The commands of ``kinetostatics``, one module each."""
