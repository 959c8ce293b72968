"""What a table holds between its points."""

import numpy as np
from numba import njit


@njit(nogil=True, cache=True)
def add_bilinear(table, x_first, y_first, x, y, scale, weights):
    """Add to weights (H, W, P) what the table (Y, X, P) holds at the points x, y (H, W), bilinear, over scale."""
    rows, columns, zones = table.shape
    for v in range(x.shape[0]):
        for u in range(x.shape[1]):
            at_x, at_y = x[v, u] - x_first, y[v, u] - y_first
            # Outside the table there is nothing to add, and a pixel's width leads there.
            if not (-1 < at_x < columns and -1 < at_y < rows):
                continue
            left, top = int(np.floor(at_x)), int(np.floor(at_y))
            for row in (top, top + 1):
                for column in (left, left + 1):
                    if 0 <= row < rows and 0 <= column < columns:
                        share = (1 - abs(at_x - column)) * (1 - abs(at_y - row)) / scale
                        for p in range(zones):
                            weights[v, u, p] += share * table[row, column, p]
