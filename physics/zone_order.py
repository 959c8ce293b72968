"""The order of zones: which share of whose place each takes, as `mirrored_zones` has it."""

import numpy as np

from physics.effect import Values


def taken(grid: tuple[int, int], values: Values) -> np.ndarray:
    """(P, P) share of each zone (columns) in what each comes to be (rows)."""
    mirrored = exchange(grid, values["rows"], values["columns"], values["transposed"])
    return mirrored @ exchanged(grid, values) @ reordered(grid, values)


def exchanged(grid: tuple[int, int], values: Values) -> np.ndarray:
    """(P, P) share of each zone's weights (columns) in those it has (rows) after two are exchanged."""
    rows, columns = grid
    mixed = np.eye(rows * columns)
    for name, count, widen in (
        ("zones_exchanged", rows * columns, lambda m: m),
        ("rows_exchanged", rows, lambda m: np.kron(m, np.eye(columns))),
        ("columns_exchanged", columns, lambda m: np.kron(np.eye(rows), m)),
    ):
        if values[name]:
            one, other = (_hat(values[which], count) for which in ("first", "second"))
            # Of the identity, this leaves both where they were or takes either for the other.
            mixed = (np.eye(mixed.shape[0]) - values[name] * widen(np.outer(one - other, one - other))) @ mixed
    return mixed


def reordered(grid: tuple[int, int], values: Values) -> np.ndarray:
    """(P, P) share of each zone's weights (columns) in those it has (rows) after all have another order."""
    own = np.eye(grid[0] * grid[1])
    place = np.broadcast_to(np.round(values["place"]).astype(int), len(own))
    if not values["reordered"] or not np.array_equal(np.sort(place), np.arange(len(own))):
        return own
    return (1 - values["reordered"]) * own + values["reordered"] * own[place]


def _hat(place: float, count: int) -> np.ndarray:
    """(count,) share of each line at a place that may be between two."""
    return np.maximum(1 - np.abs(np.arange(count) - place), 0)


def exchange(grid: tuple[int, int], rows: float, columns: float, transposed: float) -> np.ndarray:
    """(P, P) share of each zone's weights (columns) in those it comes to have (rows)."""
    zones = np.arange(grid[0] * grid[1]).reshape(grid)
    mixed = own = np.eye(zones.size)
    for share, other in ((rows, zones[::-1]), (columns, zones[:, ::-1]), (transposed, zones.T)):
        if share:
            mixed = ((1 - share) * own + share * own[other.ravel()]) @ mixed
    return mixed
