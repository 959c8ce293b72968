"""A device that is opened again whenever it went away."""

import contextlib
import time
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from devices.captures import DeviceLost
from recordings.refusal import Refusal


class Closes(Protocol):
    """Anything that can be let go of."""

    def close(self) -> None:
        """Let go."""


Device = TypeVar("Device", bound=Closes)
Result = TypeVar("Result")
AGAIN_S = 0.5
TRIES = 4


class Kept(Generic[Device]):
    """The device that `opener` opens; `use` it, and it is opened anew where it was lost.

    what: its name in sentences. patience_s: for how long it may stay away. tell: hears what happened. lost: how often
    it did. opener may raise `Refusal` or `DeviceLost` as long as the device is away.
    """

    def __init__(
        self,
        what: str,
        opener: Callable[[], Device],
        tell: Callable[[str], None] = lambda sentence: None,
        patience_s: float = 600.0,
        again_s: float = AGAIN_S,
    ) -> None:
        self.what, self.lost = what, 0
        self._opener, self._tell, self._patience_s, self._again_s = opener, tell, patience_s, again_s
        self._device: Device | None = None

    @property
    def device(self) -> Device:
        """The device, opened; `Refusal` where it cannot be. One that goes away while it is opened is tried again."""
        for left in reversed(range(TRIES)):
            if self._device is not None:
                break
            try:
                self._device = self._opener()
            except DeviceLost as lost:
                if not left:
                    raise Refusal(f"{self.what}: {lost}; tried {TRIES} times, see to its cable and power") from None
                time.sleep(self._again_s)
        return self._device

    def use(self, work: Callable[[Device], Result]) -> Result:
        """What `work` makes of the device, begun anew where the device was lost in the middle of it."""
        while True:
            try:
                return work(self.device)
            except DeviceLost as lost:
                self.lost += 1
                self._tell(f"{self.what}: {lost}; waiting for it to come back")
                self.close()
                self._await()

    def close(self) -> None:
        """Let go of the device, in whatever state it is."""
        device, self._device = self._device, None
        if device is not None:
            with contextlib.suppress(DeviceLost, Refusal, OSError):
                device.close()

    def _await(self) -> None:
        """Try until the device is there again, or for as long as patience lasts."""
        given_up = time.monotonic() + self._patience_s
        while True:
            try:
                self._device = self._opener()
                self._tell(f"{self.what}: is back")
                return
            except (Refusal, DeviceLost) as away:
                if time.monotonic() > given_up:
                    raise Refusal(f"{self.what}: did not come back within {self._patience_s:g} s: {away}") from None
                time.sleep(self._again_s)
