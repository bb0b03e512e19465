# Figures 1 to 5: what the projection and its derivatives do to each frequency (section 2.4 of the paper).
OPERATOR = sources("basis.py", "response.py", "projection/*.py")
DRAWING = sources("report/style.py", "report/frequency.py")
FIGURES = f"{OUT}/figures"
ORDER = {"figure_2": 1, "figure_3": 1, "figure_4": 2, "figure_5": 2}
CHECKED += [f"figure_{number}" for number in range(1, 6)]
ARTEFACTS += expand(f"{FIGURES}/figure_{{number}}.{{suffix}}", number=range(1, 6), suffix=["csv", "svg", "png"])


rule attenuation:
    input:
        OPERATOR,
        script=f"{SCRIPTS}/frequency_tables.py",
    output:
        f"{FIGURES}/figure_1.csv",
    params:
        settings=section("projection", "attenuation"),
    log:
        f"{OUT}/logs/attenuation.log",
    resources:
        runtime=10,
    run:
        shell("{PYTHON} {input.script} attenuation {params.settings:q} {output} > {log} 2>&1")


rule derivatives:
    input:
        OPERATOR,
        script=f"{SCRIPTS}/frequency_tables.py",
    output:
        f"{FIGURES}/{{name}}.csv",
    params:
        settings=section("projection", "derivatives"),
        order=lambda wildcards: ORDER[wildcards.name],
    log:
        f"{OUT}/logs/derivatives_{{name}}.log",
    wildcard_constraints:
        name="figure_[24]",
    run:
        shell("{PYTHON} {input.script} derivatives {params.settings:q} {output} --order {params.order} > {log} 2>&1")


rule distortion:
    input:
        OPERATOR,
        script=f"{SCRIPTS}/frequency_tables.py",
    output:
        f"{FIGURES}/{{name}}.csv",
    params:
        settings=section("projection", "distortion"),
        order=lambda wildcards: ORDER[wildcards.name],
    log:
        f"{OUT}/logs/distortion_{{name}}.log",
    wildcard_constraints:
        name="figure_[35]",
    run:
        shell("{PYTHON} {input.script} distortion {params.settings:q} {output} --order {params.order} > {log} 2>&1")


rule figure_1:
    input:
        DRAWING,
        script=f"{SCRIPTS}/frequency_figures.py",
        table=f"{FIGURES}/figure_1.csv",
    output:
        svg=report(
            f"{FIGURES}/figure_1.svg",
            caption="../report/figure_1.rst",
            category="Frequency response",
            labels={"figure": "1", "shows": "attenuation of a sine by degree and frequency"},
        ),
        png=f"{FIGURES}/figure_1.png",
    params:
        settings=section("attenuation"),
    log:
        f"{OUT}/logs/figure_1.log",
    run:
        shell("{PYTHON} {input.script} attenuation {params.settings:q} {input.table} {output} > {log} 2>&1")


rule figure_2:
    input:
        DRAWING,
        script=f"{SCRIPTS}/frequency_figures.py",
        table=f"{FIGURES}/figure_2.csv",
    output:
        svg=report(
            f"{FIGURES}/figure_2.svg",
            caption="../report/figure_2.rst",
            category="Frequency response",
            labels={"figure": "2", "shows": "first derivative, exact and rebuilt"},
        ),
        png=f"{FIGURES}/figure_2.png",
    params:
        settings=section("derivatives"),
        order=1,
    log:
        f"{OUT}/logs/figure_2.log",
    run:
        shell(
            "{PYTHON} {input.script} derivatives {params.settings:q} {input.table} {output}"
            " --order {params.order} > {log} 2>&1"
        )


use rule figure_2 as figure_4 with:
    input:
        DRAWING,
        script=f"{SCRIPTS}/frequency_figures.py",
        table=f"{FIGURES}/figure_4.csv",
    output:
        svg=report(
            f"{FIGURES}/figure_4.svg",
            caption="../report/figure_4.rst",
            category="Frequency response",
            labels={"figure": "4", "shows": "second derivative, exact and rebuilt"},
        ),
        png=f"{FIGURES}/figure_4.png",
    params:
        settings=section("derivatives"),
        order=2,
    log:
        f"{OUT}/logs/figure_4.log",


rule figure_3:
    input:
        DRAWING,
        script=f"{SCRIPTS}/frequency_figures.py",
        table=f"{FIGURES}/figure_3.csv",
    output:
        svg=report(
            f"{FIGURES}/figure_3.svg",
            caption="../report/figure_3.rst",
            category="Frequency response",
            labels={"figure": "3", "shows": "distortion of the first derivative"},
        ),
        png=f"{FIGURES}/figure_3.png",
    params:
        settings=section("distortion"),
        order=1,
    log:
        f"{OUT}/logs/figure_3.log",
    run:
        shell(
            "{PYTHON} {input.script} distortion {params.settings:q} {input.table} {output}"
            " --order {params.order} > {log} 2>&1"
        )


use rule figure_3 as figure_5 with:
    input:
        DRAWING,
        script=f"{SCRIPTS}/frequency_figures.py",
        table=f"{FIGURES}/figure_5.csv",
    output:
        svg=report(
            f"{FIGURES}/figure_5.svg",
            caption="../report/figure_5.rst",
            category="Frequency response",
            labels={"figure": "5", "shows": "distortion of the second derivative"},
        ),
        png=f"{FIGURES}/figure_5.png",
    params:
        settings=section("distortion"),
        order=2,
    log:
        f"{OUT}/logs/figure_5.log",
