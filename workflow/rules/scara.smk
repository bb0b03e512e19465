# Table 1 and figure 7: the paper's robot moves in closed loop, six estimators identify it, another record judges them.
SCARA = f"{OUT}/scara"
TABLE_1 = ["csv", "md", "tex"]
ARTEFACTS += [*expand(f"{FIGURES}/table_1.{{suffix}}", suffix=TABLE_1), f"{OUT}/check/table_1.txt"]
ARTEFACTS += expand(f"{config['reference']}/table_1.{{suffix}}", suffix=TABLE_1) if config["publish"] else []
ARTEFACTS += multiext(f"{FIGURES}/figure_7", ".csv", ".svg", ".png")
CHECKED.append("figure_7")
STUDY = [f"{SCRIPTS}/study.py", *sources("*.py", "robots/*.py", "effects/*.py", "model/*.py", "simulate/*.py")]
ESTIMATION = sources("projection/*.py", "equations/*.py", "estimators/*.py", "log/*.py")


rule motion:
    input:
        STUDY,
        sources("excite/*.py"),
        config["scara"]["model"],
        "data/motions.yaml",
        script=f"{SCRIPTS}/motion.py",
    output:
        f"{SCARA}/motion_{{name}}.csv",
    params:
        settings=section("scara"),
    log:
        f"{OUT}/logs/motion_{{name}}.log",
    wildcard_constraints:
        name="|".join(config["scara"]["motions"]),
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {wildcards.name} {output} > {log} 2>&1")


rule record:
    input:
        STUDY,
        config["scara"]["model"],
        script=f"{SCRIPTS}/record.py",
        motion=f"{SCARA}/motion_{{name}}.csv",
    output:
        f"{SCARA}/record_{{name}}.csv",
    params:
        settings=section("scara"),
    log:
        f"{OUT}/logs/record_{{name}}.log",
    wildcard_constraints:
        name="|".join(config["scara"]["motions"]),
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {input.motion} {output} > {log} 2>&1")


rule table_1:
    input:
        STUDY,
        ESTIMATION,
        config["scara"]["model"],
        f"{SCRIPTS}/shown.py",
        script=f"{SCRIPTS}/table_1.py",
        record=f"{SCARA}/record_identify.csv",
    output:
        report(
            multiext(f"{FIGURES}/table_1", ".csv", ".md", ".tex"),
            caption="../report/table_1.rst",
            category="The paper's robot",
            labels={"figure": "table 1", "shows": "six estimators on one record"},
        ),
    params:
        settings=section("scara"),
    log:
        f"{OUT}/logs/table_1.log",
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {input.record} {output} > {log} 2>&1")


rule figure_7:
    input:
        STUDY,
        ESTIMATION,
        sources("report/style.py", "report/torques.py"),
        config["scara"]["model"],
        script=f"{SCRIPTS}/figure_7.py",
        record=f"{SCARA}/record_identify.csv",
        other=f"{SCARA}/record_validate.csv",
    output:
        table=f"{FIGURES}/figure_7.csv",
        svg=report(
            f"{FIGURES}/figure_7.svg",
            caption="../report/figure_7.rst",
            category="The paper's robot",
            labels={"figure": "7", "shows": "measured and rebuilt torques"},
        ),
        png=f"{FIGURES}/figure_7.png",
    params:
        settings=section("scara"),
    log:
        f"{OUT}/logs/figure_7.log",
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {input.record} {input.other} {output} > {log} 2>&1")


rule publish_page:
    input:
        lambda wildcards: f"{OUT}/check/table_1.txt" if wildcards.page.startswith("table_1") else [],
        script=f"{SCRIPTS}/publish.py",
        made=f"{FIGURES}/{{page}}",
    output:
        update(f"{config['reference']}/{{page}}"),
    params:
        accept="--accept" if config["accept"] else "",
    log:
        f"{OUT}/logs/publish_{{page}}.log",
    wildcard_constraints:
        page=r"table_1\.(csv|md|tex)|monte_carlo\.md",  # figures with pictures: rule publish
    run:
        shell("{PYTHON} {input.script} {input.made} --to {output} {params.accept} > {log} 2>&1")
