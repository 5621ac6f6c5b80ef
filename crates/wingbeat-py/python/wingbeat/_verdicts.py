"""What a result says of itself, as warnings."""

import json
import warnings
from typing import Any


class ResultWarning(UserWarning):
    """What a reader of a result must know; ``id`` is the name that ``summary["warnings"]`` has, or ``status.NAME``."""

    def __init__(self, identity: str, text: str) -> None:
        self.id, self._text = str(identity), str(text)
        super().__init__(f"{self.id}: {self._text}")

    def __reduce__(self) -> tuple[Any, ...]:
        return ResultWarning, (self.id, self._text)


# Statuses of which nothing needs to be said.
_QUIET = {"ok", "converged"}


def judged(text: str) -> dict[str, Any]:
    """The summary that ``text`` is; warns of what it warns of, and of a status that is not ``ok``."""
    summary: dict[str, Any] = json.loads(text)
    found = summary.get("warnings") or []
    said = [(each["id"], each["text"]) if isinstance(each, dict) else ("result", each) for each in found]
    status, reason = str(summary.get("status", "ok")), str(summary.get("reason") or "see the summary")
    if status not in _QUIET and reason not in (words for _, words in said):
        said.append((f"status.{status}", reason))
    for identity, words in said:
        warnings.warn(ResultWarning(identity, words), stacklevel=3)
    return summary
