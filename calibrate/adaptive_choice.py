"""Which positions to measure next: those that leave the least expected error of the maps, all zones weighed."""

import numpy as np


def best_cells(covariance: np.ndarray, cell: np.ndarray, cost: np.ndarray, noise: np.ndarray, count: int) -> np.ndarray:
    """(count,) cells, each of which reduces the expected error most, given all before it.

    covariance: (N, N) of responses, each of which belongs to a cell (N,). cost: (N,) of a squared error in each.
    noise: (N,) variance of a measurement. Measuring response j reduces the cost by Σ cost · covariance(:, j)² /
    (covariance(j, j) + noise) (Cohn 1996; A-optimal design); what a cell's zones tell is summed.
    """
    covariance, cost, left = covariance.copy(), cost.copy(), np.unique(cell)
    chosen = []
    for _ in range(min(count, len(left))):
        own = np.diag(covariance)
        # What is measured is known with its error, as the full map has it.
        value = (cost @ np.square(covariance) + cost * noise * (2 * own + noise)) / (own + noise)
        by_cell = np.bincount(cell, value, minlength=int(cell.max()) + 1)
        by_cell[chosen] = -1
        chosen.append(int(by_cell.argmax()))
        mine = np.flatnonzero(cell == chosen[-1])
        cost[mine] = 0
        reach = covariance[:, mine]
        covariance -= reach @ np.linalg.solve(reach[mine] + np.diag(noise[mine]), reach.T)
    return np.array(chosen, int)


def short_order(xy: np.ndarray) -> np.ndarray:
    """(n,) an order of the points `xy` (n, 2) of short travel: nearest next, then crossings undone (2-opt)."""
    n = len(xy)
    if n < 3:
        return np.arange(n)
    apart = np.linalg.norm(xy[:, None] - xy, axis=2)
    order, left = [int(xy.sum(axis=1).argmin())], set(range(n))
    left.remove(order[0])
    while left:
        order.append(min(left, key=lambda i: apart[order[-1], i]))
        left.remove(order[-1])
    order, better = np.array(order), True
    while better:
        better = False
        for i in range(n - 2):
            # Between i and i + 1 the tour is cut, and between each later point j and the one after it.
            j = np.arange(i + 2, n)
            after = np.minimum(j + 1, n - 1)
            last = j == n - 1
            gain = apart[order[i], order[i + 1]] - apart[order[i], order[j]]
            gain = gain + np.where(last, 0, apart[order[j], order[after]] - apart[order[i + 1], order[after]])
            if gain.max() > 1e-9:
                stop = int(j[gain.argmax()]) + 1
                order[i + 1 : stop] = order[i + 1 : stop][::-1]
                better = True
    return order


def farthest(field: np.ndarray, allowed: np.ndarray, visited: np.ndarray, count: int) -> np.ndarray:
    """(count,) allowed cells, each the farthest from all before it and from `visited` (n, 2)."""
    nearest = np.full(len(field), np.inf)
    for point in visited:
        np.minimum(nearest, np.square(field - point).sum(axis=1), out=nearest)
    chosen = []
    for _ in range(min(count, int(allowed.sum()))):
        best = int(np.where(allowed, nearest, -1).argmax())
        chosen.append(best)
        np.minimum(nearest, np.square(field - field[best]).sum(axis=1), out=nearest)
    return np.array(chosen, int)
