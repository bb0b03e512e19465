"""Where a model fails, on what its error depends, which effects explain it, and how surely."""

from chebid.critique.diagnosis import Case, Diagnosis, diagnose, failing
from chebid.critique.document import diagnosis_document, effect_document, refinement_document
from chebid.critique.evidence import Held
from chebid.critique.found import Found
from chebid.critique.kinds import addable_kinds, candidate_kinds
from chebid.critique.refine import Refinement, Step, held_covariance, on_floor, refine, settle_hyper
from chebid.critique.verdict import Verdict
from chebid.critique.words import label, message

__all__ = [
    "Case",
    "Diagnosis",
    "Found",
    "Held",
    "Refinement",
    "Step",
    "Verdict",
    "addable_kinds",
    "candidate_kinds",
    "diagnose",
    "diagnosis_document",
    "effect_document",
    "failing",
    "held_covariance",
    "label",
    "message",
    "on_floor",
    "refine",
    "refinement_document",
    "settle_hyper",
]
