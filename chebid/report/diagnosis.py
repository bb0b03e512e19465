"""A diagnosis for the terminal: DATA, FILTER, COMPARE, WHERE, DEPENDS, CANDIDATES, VERDICT, from top to bottom."""

from collections.abc import Sequence

from chebid.critique import Diagnosis, Found, Refinement, Step, label, message
from chebid.critiques import Addition
from chebid.effects import Units
from chebid.report.tables import console, number, percent, show_estimates, table

_TOLD = 5
_WORTH_TELLING = 3.0  # score


def show_diagnosis(d: Diagnosis) -> None:
    """Every section, in the order in which a person asks."""
    out = console()
    for title, body in (
        ("DATA", _data(d)),
        ("FILTER", _filter(d)),
    ):
        out.print(f"{title:<10}  {body[0]}")
        for line in body[1:]:
            out.print(f"{'':<10}  {line}")
    out.print()
    for title, heads, rows, left in (
        ("COMPARE", *_compare(d), 1),
        ("WHERE", *_where(d), 2),
        ("DEPENDS", *_depends(d), 2),
        ("CANDIDATES", *_candidates(d.found, d), 1),
    ):
        if rows:
            out.print(title)
            out.print(table(None, heads, rows, left))
        else:
            out.print(f"{title:<10}  nothing stands out")
        out.print()
    out.print(f"VERDICT     {message(d)}", soft_wrap=True)


def _data(d: Diagnosis) -> list[str]:
    logs = d.problem.logs
    samples = sum(len(track.motion.t) for track in d.problem.tracks)
    seconds = sum(float(track.motion.t[-1] - track.motion.t[0]) for track in d.problem.tracks)
    count = f"{len(logs)} log{'s' if len(logs) > 1 else ''}, {len(d.problem.tracks)} record"
    head = f"{count}{'s' if len(d.problem.tracks) > 1 else ''}, {seconds:.3g} s, {samples} samples"
    notices = [str(notice) for notice in d.notices]
    warnings = f"{len(notices) or 'no'} warning{'' if len(notices) == 1 else 's'}{':' if notices else ''}"
    return [f"{head}, {warnings}", *notices]


def _filter(d: Diagnosis) -> list[str]:
    gate = ", ".join(
        f"{joint} {value:.2g} {Units(turns).velocity}"
        for joint, value, turns in zip(
            d.evidence.dynamics.joints, d.problem.gate, d.evidence.dynamics.robot.rotary, strict=True
        )
    )
    return [
        f"positions to {d.problem.bandwidth:.3g} Hz, equations to {d.problem.band.frequency:.3g} Hz, "
        f"effects judged to {d.evidence.ground.band:.3g} Hz; gate {gate}"
    ]


def _compare(d: Diagnosis) -> tuple[Sequence[str], list[Sequence[str]]]:
    heads = ["joint", "rms", "relative", "noise floor", "ratio", "explainable"]
    rows: list[Sequence[str]] = []
    for joint, r in d.residual.items():
        share = None if not r.ratio else max(0.0, 1 - 1 / r.ratio**2)
        row = [joint, number(r.rms, 3), percent(r.relative), number(r.floor, 3), number(r.ratio, 3), percent(share)]
        rows.append([*row, number(d.holdout_ratio[joint], 3)] if d.holdout_ratio else row)
    return ([*heads, "hold-out ratio"] if d.holdout_ratio else heads), rows


def _where(d: Diagnosis) -> tuple[Sequence[str], list[Sequence[str]]]:
    joints = d.evidence.dynamics.joints
    rows: list[Sequence[str]] = [
        (joints[c.joint], c.variable, f"{c.low:.3g} to {c.high:.3g}", number(c.ratio, 3), number(c.mean, 2))
        for c in d.cells
    ]
    return ("joint", "where", "from to", "error / noise", "mean"), rows


def _depends(d: Diagnosis) -> tuple[Sequence[str], list[Sequence[str]]]:
    joints = d.evidence.dynamics.joints
    rows: list[Sequence[str]] = [(joints[on.joint], on.variable, number(on.score, 3)) for on in d.depends[:_TOLD]]
    return ("joint", "on", "score"), rows


def _candidates(found: Sequence[Found], d: Diagnosis) -> tuple[Sequence[str], list[Sequence[str]]]:
    joints = d.evidence.dynamics.joints
    told = [one for one in found if one.score > _WORTH_TELLING][:_TOLD]
    heads = ["effect", "score", "stability", "ratio after", "parameters"]
    if d.holdout_ratio:
        heads[2:2] = ["hold-out"]
    rows: list[Sequence[str]] = []
    for one in told:
        after = ", ".join(number(value, 3) for value in (one.ratio_after or {}).values())
        values = ", ".join(f"{p.parameter.name} {number(p.value, 3)} {p.parameter.unit}" for p in one.parameters[:3])
        name = f"{label(one.effect, joints)}{' (refuted)' if one.refuted else ''}"
        row = [name, number(one.score, 3), percent(one.stability), after, values]
        if d.holdout_ratio:
            row[2:2] = [number(one.holdout, 3)]
        rows.append(row)
    return heads, rows


def show_step(step: Step) -> str:
    """One line of the ladder."""
    joints = step.diagnosis.evidence.dynamics.joints
    name = label(step.effect, joints) if step.effect else "model as given"
    ratios = ", ".join(f"{joint} {number(r.ratio, 3)}" for joint, r in step.estimate.residual.items())
    held = step.diagnosis.holdout_ratio
    beside = f"; hold-out {', '.join(f'{j} {number(v, 3)}' for j, v in held.items())}" if held else ""
    return f"{name}: error / noise floor {ratios}{beside}"


def show_refinement(refinement: Refinement) -> None:
    """The ladder of errors, and the last diagnosis."""
    last = refinement.last.diagnosis
    joints = last.evidence.dynamics.joints
    heads = ["step", *(f"ratio {joint}" for joint in joints), *(f"relative {joint}" for joint in joints)]
    heads += [f"hold-out {joint}" for joint in joints] if last.holdout_ratio else []
    rows = []
    for step in refinement.steps:
        name = f"+ {label(step.effect, joints)}" if step.effect else "model as given"
        residual = step.estimate.residual.values()
        row = [name, *(number(r.ratio, 3) for r in residual), *(percent(r.relative) for r in residual)]
        held = step.diagnosis.holdout_ratio
        rows.append(row + ([number(v, 3) for v in held.values()] if held else []))
    out = console()
    out.print("LADDER")
    out.print(table(None, heads, rows))
    out.print("ratio: error over the noise floor of the last model")
    for effect in refinement.dropped:
        out.print(f"dropped again: {label(effect, joints)}")
    for one in refinement.added:
        doubt = "surely" if one.verdict.sure else "not surely"
        rivals = ", ".join(label(other.effect, joints) for other in one.verdict.alternatives)
        out.print(f"added {label(one.effect, joints)} ({doubt}{f'; rivals: {rivals}' if rivals else ''})")
    out.print(f"VERDICT     {message(last)}", soft_wrap=True)


def _short(value: object) -> str:
    return number(value, 4) if isinstance(value, float) else str(value)


def show_addition(done: Addition) -> None:
    """Error before and after, and the parameters of the new fit."""
    heads = ["joint", "relative before", "after", "ratio before", "after"]
    heads += ["hold-out ratio before", "after"] if done.holdout else []
    rows = []
    for joint, after in done.after.residual.items():
        before = done.before.residual[joint]
        row = [
            joint,
            percent(before.relative),
            percent(after.relative),
            number(before.ratio, 3),
            number(after.ratio, 3),
        ]
        if done.holdout:
            held = done.holdout[joint]
            row += [number(held["before"]["ratio"], 3), number(held["after"]["ratio"], 3)]
        rows.append(row)
    out = console()
    out.print(f"added {', '.join(done.effects)}")
    out.print(table(None, heads, rows))
    out.print("ratio: error over the noise floor of the new model")
    for name, values in done.problem.dynamics.hyperparameters().items():
        out.print(f"{name}: " + ", ".join(f"{key} = {_short(value)}" for key, value in values.items()))
    out.print()
    show_estimates([done.after])
