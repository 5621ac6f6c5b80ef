"""Flies the banking turn for a second and draws it."""

import wingbeat

scenario = wingbeat.shipped("scenarios/banking_turn.toml")
flight = wingbeat.fly(scenario, {"flight.duration_s": 1.0})
print(flight.status, f"{flight.summary['altitude_change_m']:.3f} m")
table = flight.record.to_pandas()
print(table[["t", "roll", "pitch"]].tail(3), table.attrs["units"]["roll"])
flight.plot().savefig("banking_turn.png")
