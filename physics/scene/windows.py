"""Views in batches, each with the views around it that effects look at."""

from collections.abc import Iterable, Iterator

from physics.scene.view import View


def windows(
    views: Iterable[View], size: int, start_s: float, reaches: Iterable[tuple[float, float]]
) -> Iterator[tuple[list[View], slice]]:
    """Batches of `size` views in turn: the views that are needed for one, and where among them it stands.

    reaches: how many seconds before and after a view each effect in turn looks at others, (0, 0) where it does not.
    For each, views go on to the first at or beyond either end, or to the end of the recording, so that what is made of
    a batch does not depend on its size. Times count from `start_s`, as the effects count them. No more views are held
    than these.
    """
    views, reaches = iter(views), [reach for reach in reaches if any(reach)]
    held: list[View] = []
    at = 0

    def time(i: int) -> float:
        return held[i].timestamp_s - start_s

    def more() -> bool:
        view = next(views, None)
        if view is not None:
            held.append(view)
        return view is not None

    while True:
        while len(held) < at + size and more():
            pass
        count = min(size, len(held) - at)
        if count == 0:
            return
        first, last = at, at + count - 1
        for before, after in reaches:
            until, since = time(last) + after, time(first) - before
            while time(last) < until and (last + 1 < len(held) or more()):
                last += 1
            while time(first) > since and first > 0:
                first -= 1
        del held[:first]
        at -= first
        yield held[: last + 1 - first], slice(at, at + count)
        at += count
