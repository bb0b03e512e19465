"""chebid: from a robot's log to a dynamic model one can trust."""

__version__ = "0.1.0"
