# The hidden-effect study: logs with an effect hidden in them, what chebid says of them, and one worked example.
#
#   snakemake                                             a few logs, as a part of the main job
#   snakemake hidden --configfile config/study.yaml       all of it: at most an hour on 2 cores; resumes where it was
from hiding import cases, motions_of

HIDDEN = f"{OUT}/hidden"
STUDIED = config["hidden"]
HIDDEN_PAGES = ["hidden_accuracy.csv", "hidden_accuracy.svg", "hidden_accuracy.png", "hidden_confusion.csv"]
HIDDEN_PAGES += ["hidden_confusion.svg", "hidden_confusion.png", "hidden_summary.csv", "hidden_summary.md"]
CRITICISM = sources("critique/*.py", "critiques.py", "cli/diagnose.py", "cli/refine.py", "cli/simulate.py")
HIDDEN_LOG = [f"{SCRIPTS}/hiding.py", f"{SCRIPTS}/command.py", STUDIED["model"], STUDIED["given"]]
ARTEFACTS += [f"{FIGURES}/{page}" for page in HIDDEN_PAGES]
ARTEFACTS += multiext(f"{FIGURES}/hidden_strip", ".csv", ".svg", ".png")
CHECKED.append("hidden_strip")


rule hidden:
    input:
        [f"{FIGURES}/{page}" for page in HIDDEN_PAGES],
        [f"{config['reference']}/{page}" for page in HIDDEN_PAGES] if STUDIED["publish"] else [],


rule hidden_motion:
    input:
        sources("excite/*.py"),
        model=STUDIED["model"],
    output:
        f"{HIDDEN}/motion_{{kind}}_{{number}}.csv",
    params:
        size=lambda wildcards: " ".join(
            f"--{name} {value}"
            for name, value in (STUDIED["motion"] | STUDIED["motions"][wildcards.kind] | {"kind": wildcards.kind}).items()
        ),
    log:
        f"{OUT}/logs/hidden_motion_{{kind}}_{{number}}.log",
    run:
        shell(
            "{PYTHON} -c 'from chebid.cli import main; main()' excite {input.model} {params.size}"
            " --seed {wildcards.number} -o {output} --force > {log} 2>&1"
        )


rule hidden_log:
    input:
        CRITICISM,
        ESTIMATION,
        STUDY,
        HIDDEN_LOG,
        script=f"{SCRIPTS}/hidden_log.py",
        motions=lambda wildcards: [f"{HIDDEN}/{name}.csv" for name in motions_of(wildcards.case, STUDIED)],
    output:
        f"{HIDDEN}/logs/{{case}}.json",
    params:
        settings=json.dumps({"hidden": {name: STUDIED[name] for name in ("model", "given", "rate")}}, sort_keys=True),
    log:
        f"{OUT}/logs/hidden_{{case}}.log",
    run:
        shell(
            "{PYTHON} {input.script} {params.settings:q} {wildcards.case} {input.motions} {output} > {log} 2>&1"
        )


rule hidden_pages:
    input:
        [*sources("report/style.py", "report/hidden.py"), f"{SCRIPTS}/hiding.py", f"{SCRIPTS}/shown.py"],
        script=f"{SCRIPTS}/hidden_pages.py",
        logs=expand(f"{HIDDEN}/logs/{{case}}.json", case=cases(STUDIED)),
    output:
        report(
            f"{FIGURES}/hidden_accuracy.svg",
            caption="../report/hidden_accuracy.rst",
            category="Hidden effects",
            labels={"figure": "accuracy", "shows": "how often the hidden effect is named first"},
        ),
        report(
            f"{FIGURES}/hidden_confusion.svg",
            caption="../report/hidden_confusion.rst",
            category="Hidden effects",
            labels={"figure": "confusion", "shows": "what was named when what was hidden"},
        ),
        report(
            f"{FIGURES}/hidden_summary.md",
            caption="../report/hidden_summary.rst",
            category="Hidden effects",
            labels={"figure": "summary", "shows": "verdicts and errors in numbers"},
        ),
        [f"{FIGURES}/{page}" for page in HIDDEN_PAGES if page.endswith((".csv", ".png"))],
    params:
        folder=lambda wildcards, output: str(Path(output[0]).parent),
    log:
        f"{OUT}/logs/hidden_pages.log",
    run:
        shell("{PYTHON} {input.script} {params.folder} {input.logs} > {log} 2>&1")


rule hidden_strip:
    input:
        CRITICISM,
        ESTIMATION,
        sources("report/style.py", "report/critique.py", "report/residuals.py"),
        STUDIED["example"].values(),
        script=f"{SCRIPTS}/hidden_strip.py",
    output:
        table=f"{FIGURES}/hidden_strip.csv",
        svg=report(
            f"{FIGURES}/hidden_strip.svg",
            caption="../report/hidden_strip.rst",
            category="Hidden effects",
            labels={"figure": "worked example", "shows": "compare, where, candidates, error falling"},
        ),
        png=f"{FIGURES}/hidden_strip.png",
    params:
        settings=json.dumps({"hidden": {"example": STUDIED["example"]}}, sort_keys=True),
    log:
        f"{OUT}/logs/hidden_strip.log",
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {output} > {log} 2>&1")


rule publish_hidden:
    input:
        script=f"{SCRIPTS}/publish.py",
        made=f"{FIGURES}/{{page}}",
    output:
        update(f"{config['reference']}/{{page}}"),
    params:
        accept="--accept" if config["accept"] else "",
    log:
        f"{OUT}/logs/publish_{{page}}.log",
    wildcard_constraints:
        page="|".join(page.replace(".", r"\.") for page in HIDDEN_PAGES),
    run:
        shell("{PYTHON} {input.script} {input.made} --to {output} {params.accept} > {log} 2>&1")
