"""The method on many real seams: what the documents claim, counted by code that runs."""
