"""How the wish becomes motion: seams placed, charts chosen, one small banded solve per seam."""
