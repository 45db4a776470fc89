"""A compiled graph and what follows from it alone: configurations, selection, entry sets."""
