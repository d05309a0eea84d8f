# make         the main job: environment, then every table and figure
# make test    environment, then all checks and tests
# make check   environment, then what takes seconds: format, lint, types, contracts, quick tests
# make docs    environment, then the documentation, results/docs/index.html
# make bench   environment, then every speed comparison
# make reproduce   environment, then a fresh run's scores beside the project's own
# make cluster     the small run through a Slurm of one node (as root, with Debian's slurm-wlm, munge)
# make audit   environment, then the pinned packages against known weaknesses, by PyPI itself
# make ui      compare the runs of results/ (or: make ui RESULTS=folder PORT=5050)
# make paper       the report page printed by the browser that is here: results/report.pdf
PYTHON ?= python3
CORES ?= 2
PORT ?= 5000
RESULTS ?= results
BIN := .venv/bin

.PHONY: run env environment static check test test-workflow test-parts ui paper docs report lock bench reproduce cluster audit

run: environment
	$(BIN)/snakemake --cores $(CORES)
	@echo
	@echo "Next: open results/report.html, compare runs with 'make ui', or change config/ and run 'make' again."
	@echo "By hand: . $(BIN)/activate && snakemake --cores $(CORES)"

env: environment
	@echo "Next: 'make' runs the main job, 'make test' the tests; '. $(BIN)/activate' makes the environment yours."

# Made again only when what it holds changes.
environment:
	@sh envs/make.sh $(PYTHON)

static: environment
	$(BIN)/ruff format --check -q .
	$(BIN)/ruff check -q .
	$(BIN)/snakefmt --check Snakefile workflow/rules
	$(BIN)/lint-imports --no-cache > /dev/null || $(BIN)/lint-imports
	$(BIN)/mypy

check: static
	$(BIN)/python -m pytest -q -m "not slow"

# Two halves of the tests run beside each other, and beside them, at first, the checks. The first
# half has the whole runs and what is shown of them; the second has all parts, and those runs that
# share nothing with others, so that both take as long. What each has to say is shown when it ends.
RUNS := tests/workflow tests/report
ALONE := $(addprefix tests/workflow/,test_faults.py test_module.py test_tracking.py)
PARTS := $(filter-out $(RUNS),$(patsubst %/,%,$(sort $(dir $(wildcard tests/*/test_*.py)))))
test: environment
	@$(MAKE) --no-print-directory --output-sync=target -kj 3 test-workflow test-parts static
	@echo "Next: 'make' runs the main job and ends with the numbers to look at first."

test-workflow:
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q $(RUNS) $(addprefix --ignore=,$(ALONE))

test-parts:
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q $(PARTS) $(wildcard tests/test_*.py) $(ALONE)

ui: environment
	@$(BIN)/python -m vibrom.tracking $(RESULTS)/mlflow.db $(PORT)

paper: environment
	@$(BIN)/python -m vibrom.report.paper $(RESULTS)/report.html $(RESULTS)/report.pdf

# Pages that open from disk; nothing is fetched.
docs: environment
	@DISABLE_MKDOCS_2_WARNING=true NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build -q --strict
	@echo "Next: open results/docs/index.html"

report: environment
	$(BIN)/snakemake --cores $(CORES) --report results/snakemake_report.html
	@echo "Next: open results/snakemake_report.html"

# In a folder of its own, so that nothing is taken from other runs. One that was interrupted goes on.
reproduce: environment
	@[ ! -d results_reproduced ] || \
	    echo "results_reproduced is there: what this code made of it is kept; delete it for a run from nothing."
	$(BIN)/snakemake --cores $(CORES) scores --config results=results_reproduced
	$(BIN)/vibrom compare results_reproduced/scores.csv

cluster: environment
	$(BIN)/uv pip install -q --python $(BIN)/python --require-hashes --no-deps -r envs/cluster.txt
	VIBROM_CLUSTER=1 $(BIN)/python -m pytest -q -s tests/cluster

# Resolve the dependencies of pyproject.toml again, for every Python that it claims.
lock: environment
	$(BIN)/uv pip compile -q --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-index-url \
	    --upgrade --extra workflow --group test --group docs --group bench pyproject.toml -o envs/requirements.txt
	echo uv | $(BIN)/uv pip compile -q --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-index-url \
	    --upgrade - -o envs/uv.txt
	echo snakemake-executor-plugin-slurm | $(BIN)/uv pip compile -q --universal --python-version 3.11 --generate-hashes --no-header \
	    --no-annotate --no-emit-index-url --upgrade -c envs/requirements.txt - -o envs/cluster.txt
	@echo "Next: 'make test' makes the environment again and tries it."

# The pinned packages against PyPI's list of known weaknesses. One that cannot be looked up is an
# error, too: a mirror without that list would pass for a clean bill.
audit: environment
	$(BIN)/uv tool run pip-audit --strict --disable-pip --require-hashes -r envs/requirements.txt -r envs/uv.txt

# How fast, against what: every comparison, results/benchmarks.csv and results/benchmarks.html.
bench: environment
	$(BIN)/python -m benchmarks
