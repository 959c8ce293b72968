"""How good depth images are, on RGB-D frames recorded through measured maps, against what one would do otherwise."""
