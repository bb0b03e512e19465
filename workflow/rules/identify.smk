# Identification of the bundled log (data/): parameters, measured and predicted torque, the fitted model.
CHECKED.append("identification")
ARTEFACTS += [f"{OUT}/model.yaml", *expand(f"{FIGURES}/identification.{{suffix}}", suffix=["csv", "svg", "png"])]


rule identification:
    input:
        sources("*.py", "projection/*.py", "robots/*.py", "effects/*.py", "equations/*.py", "estimators/*.py"),
        sources("report/style.py", "report/torques.py"),
        config["identification"].values(),
        script=f"{SCRIPTS}/identification.py",
    output:
        table=f"{FIGURES}/identification.csv",
        svg=report(
            f"{FIGURES}/identification.svg",
            caption="../report/identification.rst",
            category="Identification",
            labels={"figure": "bundled log", "shows": "measured and predicted torque"},
        ),
        png=f"{FIGURES}/identification.png",
        model=f"{OUT}/model.yaml",
    params:
        settings=section("identification"),
    log:
        f"{OUT}/logs/identification.log",
    run:
        shell("{PYTHON} {input.script} {params.settings:q} {output} > {log} 2>&1")
