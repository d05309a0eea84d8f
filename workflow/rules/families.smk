# Tables and figures, each family from its own artefacts.
#
#   snakemake --cores 2 tables          all of them (or: figures)
#   snakemake --cores 2 cost            one family (or: ablation, robustness)


def in_report(kind, family):
    """The outputs of a family: tables as .html and figures as .svg appear in Snakemake's report, with their captions."""
    return [
        shown(kind, family, path) if Path(path).suffix in (".html", ".svg") else path
        for path in files(kind, [family])
    ]


def shown(kind, family, path):
    name = Path(path).stem
    plug = name if kind == "tables" else FIGURES[family][name].plug
    return report(
        path,
        caption=caption_file(kind, plug),
        category=kind.capitalize(),
        labels={kind[:-1]: name.replace("_", " ")},
    )


def caption_file(kind, plug):
    """Snakemake takes captions from files: written where it keeps its own."""
    path, text = (
        Path(".snakemake/captions", kind, f"{plug}.rst").absolute(),
        outputs.caption(kind, plug).rst,
    )
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return str(path)


for FAMILY in PRESENT:
    for KIND in MADE:
        if not MADE[KIND][FAMILY]:
            continue

        rule:
            name:
                f"{FAMILY}_{KIND}"
            input:
                artefacts=FAMILIES[FAMILY].artefacts,
            output:
                outputs=in_report(KIND, FAMILY),
            log:
                f"<logs>/{FAMILY}_{KIND}.log",
            benchmark:
                f"<benchmarks>/{FAMILY}_{KIND}.tsv"
            params:
                step="output",
                kind=KIND,
                provenance=code("output", f"report.{KIND}", *modules(KIND, [FAMILY])),
            message:
                f"{KIND} of {FAMILY}"
            script:
                "../scripts/step.py"


for TARGET, PATHS in {
    "tables": files("tables"),
    "figures": files("figures"),
    **{
        FAMILY: files("tables", [FAMILY]) + files("figures", [FAMILY])
        for FAMILY in PRESENT
        if FAMILY != "models"
    },
}.items():

    rule:
        name:
            TARGET
        input:
            PATHS,
        localrule: True
        message:
            f"{TARGET}: everything is there"
