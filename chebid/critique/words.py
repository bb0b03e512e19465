"""The verdict in words."""

from chebid.critique.diagnosis import Diagnosis, failing
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
    return [f"{head}, most likely {name} ({best.effect.sentence}), but not surely: {_doubt(d, best)}.", _left(d, best)]


def _doubt(d: Diagnosis, best: Found) -> str:
    if any(notice.kind == "torque_lag" for notice in d.notices):
        return "the lag told under DATA makes much of the error, and comes first"
    if best.stability < 0.9:
        return f"it comes first in {100 * best.stability:.0f} % of the re-weighted logs"
    if best.holdout is not None and best.holdout < 0:
        return "it does not predict the hold-out better"
    return "much of the error stays"


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
    joints, on = d.evidence.dynamics.joints, d.verdict.depends
    if on is None:
        worst = max(d.residual, key=lambda joint: d.residual[joint].ratio or 0.0)
        out = [f"something is missing on {worst} that no known effect explains, and that no single variable tells."]
    else:
        out = [
            f"something is missing on {joints[on.joint]} that no known effect explains; the error depends on "
            f"{on.variable}.",
            "Try a formula of your own over that variable (model file: effects: - {effect: NAME, joint: "
            f'{joints[on.joint]}, formula: "..."}}).',
        ]
    if d.verdict.alternatives:
        out.append(f"The nearest known effect is {label(d.verdict.alternatives[0].effect, joints)}.")
    return out


def _nothing(d: Diagnosis) -> list[str]:
    rotary = d.evidence.dynamics.robot.rotary
    parts = [
        f"{value:.2g} {Units(turns).torque.replace('.', '·')} rms on {joint}"
        for (joint, value), turns in zip(d.verdict.smallest.items(), rotary, strict=True)
    ]
    fails = failing(d.residual, d.holdout) if d.holdout else []
    if fails:
        return [
            "nothing is missing that these logs can show;",
            f"but the model fails on the hold-out, on {', '.join(fails)}: diagnose the hold-out itself.",
        ]
    high = [f"{joint} ({r.ratio:.1f} times)" for joint, r in d.residual.items() if r.ratio and r.ratio >= 1.5]
    if high:
        late = any(notice.kind == "torque_lag" for notice in d.notices)
        reason = "the lag told under DATA" if late else "coloured noise, or something unknown"
        return [
            "no effect of the library is missing that these logs can show;",
            f"but the error is well above the noise floor on {', '.join(high)}: {reason}.",
            *([] if late else ["A motion that repeats gives a floor that assumes nothing."]),
        ]
    return ["nothing is missing that these logs can show.", f"An effect of {', '.join(parts)} would have been seen."]


def _bad(d: Diagnosis) -> list[str]:
    if any(notice.kind != "torque_lag" for notice in d.notices):
        return ["the log cannot be trusted, or is not of this robot: see the warnings under DATA, and mend them first."]
    worst = max(r.relative for r in d.residual.values())
    return [
        f"the model explains next to nothing of this log (relative error {100 * worst:.0f} %): "
        "another robot, exchanged columns, a wrong sign or unit?"
    ]
