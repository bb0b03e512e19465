"""The verdict in words."""

from chebid.critique.diagnosis import Diagnosis
from chebid.critique.found import Found
from chebid.effects import Effect, Units


def label(effect: Effect, joints: tuple[str, ...]) -> str:
    """`effect:joint`, as the commands take it."""
    return effect.name if effect.joint is None else f"{effect.name}:{joints[effect.joint]}"


def message(diagnosis: Diagnosis) -> str:
    """The verdict in a few sentences."""
    status = diagnosis.verdict.status
    return " ".join({"missing": _missing, "unknown": _unknown, "bad_data": _bad}.get(status, _nothing)(diagnosis))


def _missing(d: Diagnosis) -> list[str]:
    best, joints = d.verdict.best, d.evidence.dynamics.joints
    assert best is not None, "something is missing"
    name = label(best.effect, joints)
    since = d.verdict.changed
    if d.verdict.sure:
        head = f"{name} has changed since the fit:" if since else f"{name} is missing:"
        return [head, best.effect.sentence + ".", _left(d, best)]
    rivals = [label(other.effect, joints) for other in d.verdict.alternatives]
    head = "something has changed since the fit" if since else "an effect is missing"
    if rivals:
        listed = ", ".join([name, *rivals])
        return [f"{head}; these explain it about equally well on these logs: {listed}.", _left(d, best)]
    return [f"{head}, most likely {name} ({best.effect.sentence}), but not surely: {_doubt(best)}.", _left(d, best)]


def _doubt(best: Found) -> str:
    if best.stability < 0.9:
        return f"it comes first in {100 * best.stability:.0f} % of the re-weighted logs"
    return "it does not predict the hold-out better"


def _left(d: Diagnosis, best: Found) -> str:
    if not best.ratio_after:
        return ""
    parts = [
        f"{joint} {r.ratio:.2f} -> {after:.2f}"
        for joint, r in d.residual.items()
        if r.ratio is not None and (after := best.ratio_after.get(joint)) is not None
    ]
    return f"Error over noise floor with it: {', '.join(parts)}." if parts else ""


def _unknown(d: Diagnosis) -> list[str]:
    on = d.verdict.depends
    assert on is not None, "unknown, but seen"
    joint = d.evidence.dynamics.joints[on.joint]
    out = [
        f"something is missing on {joint} that no known effect explains; the error depends on {on.variable}.",
        "Try a formula of your own over that variable (model file, effects: formula).",
    ]
    if d.verdict.alternatives:
        nearest = label(d.verdict.alternatives[0].effect, d.evidence.dynamics.joints)
        out.append(f"The nearest known effect is {nearest}.")
    return out


def _nothing(d: Diagnosis) -> list[str]:
    rotary = d.evidence.dynamics.robot.rotary
    parts = [
        f"{value:.2g} {Units(turns).torque.replace('.', '·')} rms on {joint}"
        for (joint, value), turns in zip(d.verdict.smallest.items(), rotary, strict=True)
    ]
    return ["nothing is missing that these logs can show.", f"An effect of {', '.join(parts)} would have been seen."]


def _bad(d: Diagnosis) -> list[str]:
    return ["the log cannot be trusted, or is not of this robot: see the warnings under DATA, and mend them first."]
