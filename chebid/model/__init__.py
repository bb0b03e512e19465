"""The model file: one schema from the first sketch of a robot to the identified model.

`read_model` turns YAML into a checked `Model`, `write_model` writes one. Unknown keys, wrong types and impossible
values are InputErrors that name the key, the row and the value.
"""

from chebid.model.blame import settings_of
from chebid.model.read import read_model
from chebid.model.schema import Covariance, EffectSpec, FitSection, FittedValue, Model, per_joint
from chebid.model.write import write_model

__all__ = [
    "Covariance",
    "EffectSpec",
    "FitSection",
    "FittedValue",
    "Model",
    "per_joint",
    "read_model",
    "settings_of",
    "write_model",
]
