"""Run all verdict checks on a model with named effects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from model.discrepancy.criticism.catalogue import origins, verdict_checks
from model.discrepancy.criticism.check_result import CheckResult, Consequence, Failure
from model.discrepancy.criticism.named_model import NamedModel
from model.identification.foreign_parts import answers_of

_RIVALS = (Consequence.EQUIVALENCE_CLASS, Consequence.INDISTINGUISHABLE)


@dataclass(frozen=True, kw_only=True)
class Criticism:
    """What the checks said."""

    results: tuple[CheckResult, ...] = ()
    failures: tuple[Failure, ...] = ()

    def rejected(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return which of the names cannot be, whatever else speaks for them."""
        return self._against(names, Consequence.REJECT)

    def doubted(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return which of the names something unknown may imitate."""
        return self._against(names, Consequence.REJECT_UNLESS_PROBABLE)

    def _against(self, names: Iterable[str], consequence: Consequence) -> tuple[str, ...]:
        failed = [f for f in self.failures if f.consequence == consequence and f.effects]
        return tuple(n for n in names if any(n in f.effects for f in failed))

    @property
    def incomplete(self) -> bool:
        """Whether something is missing that no single name is to blame for."""
        some = (f for f in self.failures if f.consequence == Consequence.REJECT)
        return any(not one.effects for one in some)

    @property
    def undecided(self) -> str:
        """Why the data do not allow a verdict; empty: they do."""
        some = (f for f in self.failures if f.consequence == Consequence.INCONCLUSIVE)
        return next((one.sentence for one in some), "")

    def overlooked(self, name: str) -> float:
        """Return the probability that nobody noticed what this name says."""
        own = (one.overlooked for one in self.failures if name in one.effects)
        return float(np.prod(list(own)))

    def rivals(self, name: str) -> tuple[str, ...]:
        """Return names that explain as much as this one."""
        some = (f for f in self.failures if f.consequence in _RIVALS)
        own = [f for f in some if name in f.effects]
        return tuple(rival for one in own for rival in one.rivals)

    def odds(self, name: str) -> dict[str, float]:
        """Return the probability over this name's of rivals that nothing tells from it.

        It is 1 at most: a name that is reported has no less than the others.
        """
        return {rival: min(odds, 1.0) for rival, odds in self._odds(name).items()}

    def likelier(self, name: str) -> str:
        """Return the rival that is likelier than a name and likeliest; empty: there is none."""
        every = self._odds(name)
        best = max(every, key=lambda rival: every[rival], default="")
        return best if best and every[best] > 1.0 else ""

    def _odds(self, name: str) -> dict[str, float]:
        own = (one for one in self.failures if one.odds and name in one.effects)
        return {
            rival: odds for one in own for rival, odds in zip(one.rivals, one.odds, strict=True)
        }

    @property
    def sentence(self) -> str:
        """Name the checks that failed; empty: none did."""
        failed = [one for one in self.results if not one.passed]
        return " ".join(f"Check '{one.name}' failed: {one.sentence}." for one in failed)


def criticise(named: NamedModel) -> Criticism:
    """Return what all checks say of the names; nothing where nothing is named."""
    if not named.named:
        return Criticism()
    results, failures = list[CheckResult](), list[Failure]()
    foreign = origins()
    for name, check in verdict_checks().items():
        found: list[Failure] | None
        if name in foreign:
            whose = f"the verdict check '{name}' of {foreign[name]}"
            ask = partial(check.failures, named)
            found = answers_of(whose, Failure, ask, "the verdict was checked")
            if found is None:
                continue
        else:
            found = list(check.failures(named))
        failures += found
        results.append(
            CheckResult(
                name=check.name,
                passed=not found,
                sentence="; ".join(one.sentence for one in found) or check.meaning,
                effects=tuple(dict.fromkeys(n for one in found for n in one.effects)),
            )
        )
    return Criticism(results=tuple(results), failures=tuple(failures))
