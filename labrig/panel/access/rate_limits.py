"""How often is too often: a bucket that fills slowly and is emptied by use."""

from __future__ import annotations

import time
from collections import OrderedDict

_MOST_ASKERS = 1000
UNIDENTIFIED = (20.0, 120.0)  # requests of one address without the token: in a second, at once


class Bucket:
    """Allows `burst` at once and `per_s` in the long run."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._left = burst
        self._then_s = time.monotonic()

    @property
    def spent(self) -> bool:
        """Whether one more is refused now."""
        now_s = time.monotonic()
        self._left = min(self._burst, self._left + (now_s - self._then_s) * self._per_s)
        self._then_s = now_s
        return self._left < 1.0

    def take(self) -> bool:
        """Whether one more is allowed now."""
        if self.spent:
            return False
        self._left -= 1.0
        return True


class Buckets:
    """One for each asker; the one that has asked least recently is forgotten first."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()

    def take(self, asker: str) -> bool:
        """Whether one more is allowed for this asker now."""
        bucket = self._buckets.pop(asker, None) or Bucket(self._per_s, self._burst)
        self._buckets[asker] = bucket
        if len(self._buckets) > _MOST_ASKERS:
            self._buckets.popitem(last=False)
        return bucket.take()

    def spent(self, asker: str) -> bool:
        """Whether one more is refused for this asker now."""
        bucket = self._buckets.get(asker)
        return bucket is not None and bucket.spent
