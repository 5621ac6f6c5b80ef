"""Environments of Gymnasium, known to it once this is imported: ``gymnasium.make("wingbeat/BankingTurn-v0")``.

A task is a small class, a :class:`Task`; what is seen and rewarded is computed by the library. A single environment is a
vector of one: its numbers do not depend on its neighbours.
"""

from wingbeat._extras import needed

needed("gymnasium", "learn")

from wingbeat.learn._environments import BankingTurn, Environment, Task, VectorEnvironment, register

__all__ = ["BankingTurn", "Environment", "Task", "VectorEnvironment"]

register()
