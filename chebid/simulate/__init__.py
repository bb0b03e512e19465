"""Closed-loop simulation: a model under joint PD control, with encoders, torque noise and dry friction that sticks.

`kernel` is compiled and integrates; robots (`plants`) and effects (`effects.forward`) plug into it; `loop` is the door.
numba is loaded by the first simulation only.
"""

from chebid.simulate.loop import NOISES, TORQUE_LOGS, Options, Simulated, simulate, simulate_batch
from chebid.simulate.reference import Reference, read_reference
from chebid.simulate.table import simulated_table

__all__ = [
    "NOISES",
    "TORQUE_LOGS",
    "Options",
    "Reference",
    "Simulated",
    "read_reference",
    "simulate",
    "simulate_batch",
    "simulated_table",
]
