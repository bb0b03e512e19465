"""Does a finding withstand what a drive does at reversals?

A joint that dry friction held jerks as its drive winds up, faster than a projection of its positions passes, and the
others feel it. What then looks like an effect is none. Findings are judged once more beside accelerations that fade
after every reversal; friction that lives there itself (presliding, Stribeck and its kin) is excepted: the motion tells
it by its speed and distance. So is a delay, which acts at reversals most of all.
"""

from dataclasses import replace

import numpy as np

from chebid.critique.candidates import penalty
from chebid.critique.depends import Dependence
from chebid.critique.evidence import Evidence, Judged
from chebid.critique.found import Found
from chebid.critique.verdict import MARGIN, believed
from chebid.effects.channel import TorqueDelay
from chebid.effects.friction import Presliding

_APART = 0.5  # of the worth of one delay for all joints, by which one delay for each would have to be better
_COUNTS = 2.0  # steps of the encoder, within which nobody knows when a joint turns round
_THERE = frozenset({TorqueDelay.name, "presliding", "stribeck", "viscous_power", "viscous_quadratic"})


def withstood(one: Found, evidence: Evidence, calm: Evidence, threshold: float) -> Found:
    """The candidate, refuted if little is left of it beside the jerks, or if it is a delay that joints do not share,
    or a bristle that bends within the steps of the encoder.
    """
    if not believed(one):
        return one
    if isinstance(one.effect, TorqueDelay) and not _shared(one, evidence):
        return replace(one, refuted=True)
    if isinstance(one.effect, Presliding) and one.effect.delta < _COUNTS * evidence.ground.counts[one.effect.joint]:
        return replace(one, refuted=True)
    if one.effect.name in _THERE:
        return one
    judged = _again(one, calm)
    score = calm.worth(judged.basis) - penalty(calm, judged, one.candidate.settings) - threshold
    return one if score > MARGIN else replace(one, refuted=True)


def _again(one: Found, calm: Evidence) -> Judged:
    """The candidate beside the jerks; the columns of one that was simulated are those it has."""
    if one.effect.linear:
        return calm.judge(one.effect)
    basis = calm.beside(one.candidate.judged.basis)
    return Judged(one.effect, basis, float(np.sum((basis.T @ calm.residual) ** 2)))


def _shared(one: Found, evidence: Evidence) -> bool:
    """Whether all joints show the same delay."""
    column = evidence.columns(one.effect)[:, 0]
    joint = evidence.rows.joint
    each = evidence.padded((joint[:, None] == range(evidence.rows.joints)) * column[: len(joint), None])
    apart = evidence.beside(each)
    together = evidence.worth(one.candidate.judged.basis)
    return evidence.worth(apart) - together < max(MARGIN, _APART * together)


def without_jerk(depends: list[Dependence], calm: list[Dependence]) -> list[Dependence]:
    """Dependences with the score and share that they have beside the jerks, if these are lower; best first."""
    beside = {(one.joint, one.variable): one for one in calm}
    lowered = []
    for one in depends:
        other = beside.get((one.joint, one.variable))
        score, share = (other.score, other.share) if other else (0.0, 0.0)
        lowered.append(replace(one, score=min(one.score, score), share=min(one.share, share)))
    return sorted(lowered, key=lambda one: -one.score)
