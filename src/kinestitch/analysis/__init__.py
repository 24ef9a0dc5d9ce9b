"""How good it is: numbers for every seam, and the curves behind them."""
