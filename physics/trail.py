"""Surfaces followed from frame to frame: in the image, or in space where the camera's motion is known."""

import numpy as np

# Relative difference of ranges by which one pixel is e times less likely to see the same still: a surface may come
# nearer by a tenth from one frame to the next.
FOLLOWED = 0.05
# So many points tell whether a surface was seen before, if so many of them are where it was.
POINTS, MOST = 64, 0.5
# What stands still otherwise than most of a frame does has this part of it in common with itself.
ALL = 0.8


class Trail:
    """Surfaces by frame, followed through those that were added. numbers, inverse: (F, H, W), and inverse depth.

    rays: (H, W, 3) of pixels, of length 1 along z. intrinsics: (3, 3). cameras: (F, 4, 4) start from camera in each
    frame, None where nobody knows.
    """

    def __init__(self, frames: int, rays: np.ndarray, intrinsics: np.ndarray, cameras: np.ndarray | None) -> None:
        self.rays, self.intrinsics, self.cameras = rays, intrinsics, cameras
        self.numbers = np.zeros((frames, *rays.shape[:2]), np.int32)
        self.inverse = np.full(self.numbers.shape, np.nan)
        self.added = self.count = 0

    def add(self, pieces: np.ndarray, inverse: np.ndarray) -> None:
        """One more frame: its pieces (H, W), numbered from 1, get the numbers that they had before, or new ones.

        Two pieces are one surface where each shares more with the other than with any third: pixels, the more they are
        of like depth. First as all stands still in the image, or in space, whichever leaves more in common; then what
        is left the other way, if nearly all of it is where it was. One that was not seen in the frame before may have
        been in another.
        """
        many = int(pieces.max(initial=0))
        number = np.zeros(many + 1, int)
        least = np.zeros(many + 1)
        for shared in sorted(self._shared(pieces, inverse, many), key=np.sum, reverse=True) if self.added else ():
            shared[number > 0] = shared[:, number] = 0
            shared[shared.max(axis=1) < least] = 0
            least = ALL * np.bincount(pieces.ravel())
            for piece in np.flatnonzero(shared.any(axis=1)):
                other = int(np.argmax(shared[piece]))
                if int(np.argmax(shared[:, other])) == piece:
                    number[piece] = other
        for piece in np.flatnonzero(number == 0)[1:] if self.added and self.cameras is not None else ():
            number[piece] = self._recalled(pieces == piece, inverse, number)
        new = np.flatnonzero(number == 0)[1:]
        number[new] = self.count + 1 + np.arange(len(new))
        self.count += len(new)
        self.numbers[self.added], self.inverse[self.added] = number[pieces], inverse
        self.added += 1

    def _shared(self, pieces: np.ndarray, inverse: np.ndarray, many: int) -> list[np.ndarray]:
        """(many + 1, count + 1) how much pieces share with surfaces of the frame before, and nothing with none.

        As all stands still in the image; and in space, where that is known.
        """
        last, shape = self.added - 1, (many + 1, self.count + 1)
        ways = [(self.numbers[last], np.log(inverse / self.inverse[last]))]
        if self.cameras is not None:
            (which,), (off,) = self._looked_up(self.rays / inverse[..., None], np.array([last]))
            ways.append((which, off))
        found = []
        for which, off in ways:
            like = np.nan_to_num(np.exp(-np.abs(off) / FOLLOWED))
            pairs = pieces.ravel() * shape[1] + which.ravel()
            shared = np.bincount(pairs, like.ravel(), shape[0] * shape[1]).reshape(shape)
            shared[0] = shared[:, 0] = 0
            found.append(shared)
        return found

    def _recalled(self, piece: np.ndarray, inverse: np.ndarray, taken: np.ndarray) -> int:
        """Number of the surface that points of a piece (H, W) were seen on in some frame before; 0 if none is."""
        where = np.flatnonzero(piece)
        some = where[:: max(1, len(where) // POINTS)]
        points = self.rays.reshape(-1, 3)[some] / inverse.ravel()[some, None]
        which, off = self._looked_up(points, np.arange(self.added))
        there = np.where(np.nan_to_num(np.abs(off), nan=np.inf) < FOLLOWED, which, 0)
        votes = np.array([np.bincount(frame, minlength=self.count + 1) for frame in there]).max(axis=0)
        votes[[0, *taken]] = 0
        best = int(np.argmax(votes))
        return best if votes[best] > MOST * len(some) else 0

    def _looked_up(self, points: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N, ...) number of the surface seen where points (..., 3) of a new frame were in each of frames (N,) before,
        and the logarithm of its depth there over theirs.
        """
        now = self.cameras[self.added]
        before = np.linalg.solve(self.cameras[frames], now)
        there = np.einsum("nij,...j->n...i", before[:, :3, :3], points)
        there += before[:, :3, 3].reshape(-1, *(1,) * (points.ndim - 1), 3)
        ahead = there[..., 2] > 0
        depth = np.where(ahead, there[..., 2], 1.0)
        at = np.where(ahead[..., None], there / depth[..., None], -1e6) @ self.intrinsics.T
        height, width = self.rays.shape[:2]
        column, row = (np.nan_to_num(np.rint(at[..., i]), nan=-1).clip(-1, 1e6).astype(int) for i in (0, 1))
        inside = ahead & (column >= 0) & (column < width) & (row >= 0) & (row < height)
        place = (frames.reshape(-1, *(1,) * (points.ndim - 1)), np.where(inside, row, 0), np.where(inside, column, 0))
        which, seen = self.numbers[place], self.inverse[place]
        return np.where(inside, which, 0), -np.log(np.where(inside, seen, np.nan) * depth)
