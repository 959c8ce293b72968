"""Maximum likelihood of light by range, from one histogram at a time."""

import numpy as np
from numba import njit

# Light below this part of its mean over ranges is taken for none and not followed.
NOTHING = 1e-5


@njit(nogil=True, cache=True, fastmath={"reassoc", "contract"})
def climb(counts, zone, response, bands, structure, held, steps, light, level):
    """Fit `light` (N, B) and flat `level` (N,) in place to N histograms (N, T) of the zones `zone` (N,).

    Counts are Poisson about Σ_b light_b · response[zone, b] + structure + level; expectation maximisation keeps
    all of it at 0 or more and never lowers the likelihood (Richardson 1972, Lucy 1974; Shepp & Vardi 1982, IEEE Trans.
    Med. Imaging 1, 113). `light` and `level` are where it begins; a level that is `held` stays.
    response: (P, B, T). bands: (P, B, 2). structure: (N, T).
    """
    bins, many = counts.shape[1], light.shape[1]
    made, ratio = np.empty(bins), np.empty(bins)
    for n in range(len(counts)):
        p = zone[n]
        reached = np.empty(many)
        for b in range(many):
            total = 0.0
            for t in range(bands[p, b, 0], bands[p, b, 1]):
                total += response[p, b, t]
            reached[b] = total
        for _ in range(steps):
            least = NOTHING * light[n].sum() / many
            for t in range(bins):
                made[t] = structure[n, t] + level[n]
            for b in range(many):
                amount = light[n, b]
                if amount > least:
                    for t in range(bands[p, b, 0], bands[p, b, 1]):
                        made[t] += amount * response[p, b, t]
            for t in range(bins):
                ratio[t] = counts[n, t] / max(made[t], 1e-9)
            for b in range(many):
                if light[n, b] > least and reached[b] > 0:
                    total = 0.0
                    for t in range(bands[p, b, 0], bands[p, b, 1]):
                        total += response[p, b, t] * ratio[t]
                    light[n, b] *= total / reached[b]
                else:
                    light[n, b] = 0.0
            if not held:
                level[n] *= ratio.sum() / bins
