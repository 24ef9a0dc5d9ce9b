"""Where to cut: what every seam would cost before anything is solved, and the cheapest of them."""
