# What was made against what is committed: a run that differs beyond the tolerance fails.


rule check:
    input:
        table=f"{OUT}/figures/{{name}}.csv",
        script=f"{SCRIPTS}/check.py",
    output:
        f"{OUT}/check/{{name}}.txt",
    params:
        reference=lambda wildcards: f"{config['reference']}/{wildcards.name}.csv",
        content=lambda wildcards: fingerprint(f"{config['reference']}/{wildcards.name}.csv"),
        settings=section("tolerance", "accept"),
    log:
        f"{OUT}/logs/check_{{name}}.log",
    run:
        shell("{PYTHON} {input.script} {input.table} {params.reference:q} {params.settings:q} {output} > {log} 2>&1")


rule publish:
    input:
        f"{OUT}/check/{{name}}.txt",
        script=f"{SCRIPTS}/publish.py",
        made=multiext(f"{OUT}/figures/{{name}}", ".csv", ".svg", ".png"),
    output:
        [update(file) for file in multiext(f"{config['reference']}/{{name}}", ".csv", ".svg", ".png")],
    params:
        accept="--accept" if config["accept"] else "",
    log:
        f"{OUT}/logs/publish_{{name}}.log",
    wildcard_constraints:
        name="|".join(CHECKED),
    run:
        shell("{PYTHON} {input.script} {input.made} --to {output} {params.accept} > {log} 2>&1")
