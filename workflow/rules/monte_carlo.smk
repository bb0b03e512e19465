# Monte-Carlo: bias, rmse and coverage of every method over many noise seeds, and the pitfalls as cases.
MC = f"{OUT}/monte_carlo"
PAGE = config["monte_carlo"]
ARTEFACTS += multiext(f"{FIGURES}/monte_carlo", ".csv", ".svg", ".png", ".md")
if config["publish"]:  # fewer seeds have other numbers
    CHECKED.append("monte_carlo")
    ARTEFACTS.append(f"{config['reference']}/monte_carlo.md")


rule monte_carlo_estimates:
    input:
        STUDY,
        ESTIMATION,
        config["scara"]["model"],
        script=f"{SCRIPTS}/monte_carlo.py",
        motion=f"{SCARA}/motion_{{name}}.csv",
    output:
        f"{MC}/{{name}}_{{part}}.csv",
    params:
        settings=section("scara", "monte_carlo"),
    log:
        f"{OUT}/logs/monte_carlo_{{name}}_{{part}}.log",
    resources:
        runtime=60,
    run:
        shell(
            "{PYTHON} {input.script} {params.settings:q} {input.motion} {output}"
            " --record {wildcards.name} --part {wildcards.part} > {log} 2>&1"
        )


rule monte_carlo_cases:
    input:
        STUDY,
        ESTIMATION,
        config["scara"]["model"],
        script=f"{SCRIPTS}/monte_carlo_cases.py",
        motions=expand(f"{SCARA}/motion_{{name}}.csv", name=["identify", "long", "eq23"]),
    output:
        f"{MC}/cases.csv",
    params:
        settings=section("scara", "monte_carlo"),
    log:
        f"{OUT}/logs/monte_carlo_cases.log",
    resources:
        runtime=60,
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {input.motions} {output} > {log} 2>&1")


rule monte_carlo:
    input:
        [*sources("report/style.py", "report/monte_carlo.py"), f"{SCRIPTS}/shown.py"],
        script=f"{SCRIPTS}/monte_carlo_page.py",
        cases=f"{MC}/cases.csv",
        parts=expand(f"{MC}/{{name}}_{{part}}.csv", name=PAGE["records"], part=range(PAGE["parts"])),
    output:
        table=f"{FIGURES}/monte_carlo.csv",
        svg=report(
            f"{FIGURES}/monte_carlo.svg",
            caption="../report/monte_carlo.rst",
            category="The paper's robot",
            labels={"figure": "Monte-Carlo", "shows": "bias, rmse and coverage of six estimators"},
        ),
        png=f"{FIGURES}/monte_carlo.png",
        md=report(
            f"{FIGURES}/monte_carlo.md",
            caption="../report/monte_carlo.rst",
            category="The paper's robot",
            labels={"figure": "Monte-Carlo", "shows": "tables, and the pitfalls"},
        ),
    params:
        settings=section("scara", "monte_carlo"),
    log:
        f"{OUT}/logs/monte_carlo.log",
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {input.cases} {input.parts} --to {output} > {log} 2>&1")
