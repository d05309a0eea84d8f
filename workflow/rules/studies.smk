# One rule a study and kind of job. What a job makes and reads is said by the constants of the
# study's class in src/vibrom/studies.


include: "planning/studies.smk"


# The longest first, beside what they wait for.
JOB_PRIORITY = {("cost", "scene"): 55, ("cost", "models"): 45, ("ablation", "scene"): 40}
JOB_PRIORITY |= {("robustness", "model"): 30, ("robustness", "scene"): 30, ("trust", "models"): 30}

for STUDY, CONSTANTS in STUDIES.items():
    for KIND, ARTEFACT in CONSTANTS["jobs"].items():
        PLACE = f"{{scene}}/{JOB_FOLDER.get(KIND, settings.FULL_ORDER)}/{ARTEFACT}"

        rule:
            name:
                f"{STUDY}_{KIND}"
            input:
                **job_reads(STUDY, KIND),
                structure=rules.structure.output.structure,
            output:
                output=f"<results>/{PLACE}.nc",
            log:
                f"<logs>/{PLACE}.log",
            benchmark:
                f"<benchmarks>/{PLACE}.tsv"
            priority: JOB_PRIORITY.get((STUDY, KIND), 0)
            conda:
                "../../envs/vibrom.yaml"
            threads: 1
            resources:
                mem_mb=memory(f"study_{KIND}"),
            params:
                step="study",
                study=job_settings(STUDY, KIND),
                names=job_names,
                case=job_case(STUDY, KIND),
                provenance=job_code(STUDY, KIND),
            message:
                f"{{wildcards.scene}}: {STUDY}, {KIND}"
            script:
                "../scripts/step.py"
