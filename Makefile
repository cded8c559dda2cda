# One command is enough on a bare machine: every target first makes .venv with everything pinned.
PYTHON ?= python3
BIN := .venv/bin
METHODS := --method avo --method abc-smc --method bolfi
# Populations of 25 give ABC-SMC several generations from a tenth of the events.
QUICK := --budget 16000 --observations 20000 --targets 0-2 --set abc-smc.population_size=25

STUDIES := poisson alignment summary ablation tuning sensitivity dimension fresh growth rivals plain smm
STUDIES += agreement contamination detector few hard misspecification saturation textbook real

# TASK-KINDS-CASES-SEED of `make challenge`, and of `make challenge FULL=1`.
CHALLENGE := poisson-none-10-0 poisson-seen-12-0 weinberg-none-10-0 weinberg-seen-12-0 carl-none-4-0 carl-seen-8-0
FULL_CHALLENGE := poisson-none-200-1098 poisson-seen-80-1111 weinberg-none-200-1099 weinberg-seen-80-1110
FULL_CHALLENGE += carl-none-200-1100 carl-seen-40-1109 alignment-none-40-7107 alignment-seen-24-1105
KINDS_none := none
KINDS_seen := own,foreign,two,withheld --shapes shapes:SEEN
JOBS ?= 1
ON_ALL_CORES := --numprocesses auto --dist loadfile --no-loadscope-reorder

.DEFAULT_GOAL := help
.PHONY: help venv test-lowest test-latest test-wheel benchmark quick figures studies pages bench-avo bench-cost bench-diagnosis bench-gpu bench-scaling bench-speed bench-store challenge demo docs fuzz soak constraints audit test browser lint size clean

help:  ## show these lines
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

venv: .venv/ready  ## create .venv with everything, pinned by constraints.txt

.venv/ready: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "avobench needs Python 3.11 or newer, this is $$($(PYTHON) --version); try make PYTHON=python3.11"; exit 2; }
	$(PYTHON) -m venv .venv
	$(call install,$(BIN)/python,--constraint constraints.txt)
	@touch $@

# uv takes a quarter of the time of pip: it fetches and compiles at once. Folders of wheels are named in the settings
# of pip, which it does not read. Pythia's newest version may have no wheel, and compiles for half an hour.
define install
$(1) -m pip install --quiet --disable-pip-version-check --constraint constraints.txt uv
UV_FIND_LINKS="$${PIP_FIND_LINKS-$$($(1) -m pip config get global.find-links 2>/dev/null)}" \
  $(1) -m uv pip install --quiet --python $(1) --compile-bytecode --only-binary pythia8mc $(2) --editable '.[dev]'
endef

benchmark: venv  ## the paper's comparison: 4 tasks x 3 methods x 15 targets into results/local, figure in reports/
	$(BIN)/avobench run $(METHODS) --figure reports

quick: venv  ## all tasks and methods on 3 targets at a tenth of the budget, into results/quick, figure in reports/
	$(BIN)/avobench run $(METHODS) $(QUICK) --results results/quick --figure reports/quick

figures: venv  ## draw the committed records into docs/figures, and write the pages on the paper's claims and on real data
	$(BIN)/avobench figure benchmark efficiency coverage --results results/reference --out docs/figures
	$(BIN)/python -m paper.figures poisson alignment detector weinberg dimension misspecification contamination --out docs/figures
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.gallery
	$(BIN)/python -m paper.figures.reliability_diagram docs/figures results/challenge/sealed-*.jsonl
	$(BIN)/python -m paper.claims.reproduction --out docs
	$(BIN)/python -m paper.tables.real --out docs/real-data.md

studies: venv  ## the paper's single experiments, the ablation and the studies beyond it into results/, as far as they lack
	for study in $(STUDIES); do $(BIN)/python -m paper.study $$study || exit 1; done

bench-speed: venv  ## side by side: BOLFI's fast process and ELFI's own
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.bolfi

bench-avo: venv  ## AVO's update by hand beside PyTorch's derivatives
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.avo

bench-scaling: venv  ## time and memory against budget, observations, targets, workers and number of cells
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.growth

bench-diagnosis: venv  ## seconds of a diagnosis against measured events and against the size of the catalogue
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.diagnosis

bench-gpu: venv  ## the methods' networks on a GPU beside the processor, on a machine that has one
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.gpu --run

bench-cost: venv  ## where the time goes, from results/reference
	$(BIN)/python -m paper.speed.cost results/reference

pages: venv  ## write into README, docs and examples what the commands and cells there print
	$(BIN)/python -m paper.printed README.md docs/*.md docs/tables/*.md
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.pages docs/index.md docs/tutorial.md docs/diagnosis.md docs/own-data.md docs/published-tables.md docs/several-data-sets.md docs/what-would-decide.md
	OMP_NUM_THREADS=1 $(BIN)/jupyter-execute --inplace --NotebookClient.record_timing=False examples/*.ipynb

docs: venv docs/figures/effects/drawn  ## build the site into site/: a warning ends it
	OMP_NUM_THREADS=1 NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo "the site is site/index.html"

# A picture of each effect, drawn again when what it shows may have changed.
docs/figures/effects/drawn: paper/effect_pictures.py $(shell find avobench/effects -name '*.py') | .venv/ready
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.effect_pictures carl avobench.tasks.decays:DECAYS poisson alignment
	@touch $@

demo: venv  ## the example of the README: a simulator, measured data, what the simulator lacks; picture in reports/
	@mkdir -p reports
	cd reports && OMP_NUM_THREADS=1 ../$(BIN)/python ../examples/gamma_line.py

challenge: $(patsubst %,challenge-%,$(if $(FULL),$(FULL_CHALLENGE),$(CHALLENGE)))  ## hide effects, find and score them; FULL=1 for all

challenge-%: venv
	$(eval TASK := $(word 1,$(subst -, ,$*)))
	$(eval PLACE := results/challenge/$(TASK)-$(word 2,$(subst -, ,$*))-$(word 3,$(subst -, ,$*)))
	@test -e $(PLACE)/manifest.json || $(BIN)/avobench challenge make --out $(PLACE) --task $(TASK) \
	  --cases $(word 3,$(subst -, ,$*)) --seed $(word 4,$(subst -, ,$*)) \
	  --kinds $(KINDS_$(word 2,$(subst -, ,$*))) --events $(if $(filter alignment-seen-%,$*),20000,50000)
	@$(BIN)/avobench challenge solve $(PLACE) --jobs $(JOBS)
	@$(BIN)/avobench challenge score $(PLACE) --records $(PLACE).jsonl

bench-store: venv  ## time and memory of the commands that read a store, up to 100 000 records
	OMP_NUM_THREADS=1 $(BIN)/python -m paper.speed.store

fuzz: venv  ## a thousand hostile inputs of every kind; a line each
	FUZZ=1000 $(BIN)/python -m pytest --quiet --capture no tests/fuzz

soak: venv  ## kills at and failures of every operation on files, several writers, a dying cluster, linked stores, dirty methods
	SOAK=1 $(BIN)/python -m pytest --quiet --capture no tests/robustness
	FUZZ=1000 FUZZ_SEED=1 $(BIN)/python -m pytest --quiet --capture no tests/fuzz -k 'linked or dirty'

# For every system and Python that pyproject.toml allows. GPU libraries are left to PyTorch, which pins its own.
constraints: venv  ## renew constraints.txt with the newest versions that go together; run the tests afterwards
	@mkdir -p build
	$(BIN)/python -m uv pip compile --quiet --universal --upgrade --python-version 3.11 --extra dev \
	  --only-binary pythia8mc --no-annotate --no-header --output-file build/constraints.txt pyproject.toml
	grep -v -E '^(cuda|nvidia|triton)' build/constraints.txt > constraints.txt

audit: venv  ## look for known vulnerabilities of what constraints.txt pins; needs the network
	$(BIN)/python -m pip install --quiet --disable-pip-version-check pip-audit
	$(BIN)/python -m pip_audit --requirement constraints.txt --no-deps --disable-pip --strict

test: venv browser  ## the test suite, on all cores
	$(BIN)/python -m pytest $(ON_ALL_CORES)

# Each in an environment of its own. Pages and figures were made with the pinned versions, so they are not compared.
test-lowest: RESOLUTION := lowest-direct  ## the suite with the lowest versions that pyproject.toml allows
test-latest: RESOLUTION := highest  ## the suite with the newest versions there are
test-lowest test-latest:
	$(PYTHON) -m venv --clear build/$@
	$(call install,build/$@/bin/python,--resolution $(RESOLUTION))
	build/$@/bin/python -m pytest $(ON_ALL_CORES) --ignore tests/docs --ignore tests/test_wheel.py

test-wheel: venv  ## the wheel in a new environment; AVOBENCH_WHEEL_PYTHON=python3.13 for another Python
	$(BIN)/python -m pytest tests/test_wheel.py

browser:  ## install the Chromium of the tests (Debian, as root); without it they skip what needs it
	@if command -v chromium >/dev/null && command -v chromedriver >/dev/null; then :; \
	elif [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	  apt-get update --quiet=2 && apt-get install --quiet=2 --yes --no-install-recommends chromium chromium-driver; \
	else echo "no chromium and chromedriver here: the tests that need a browser are skipped"; fi

lint: venv  ## style, and the direction of imports
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo

size: venv  ## lines and numeric constants by room, the longest functions; JUNIT=FILE adds the slowest tests
	$(BIN)/python -m paper.size $(JUNIT)

clean:  ## remove .venv and caches; keeps every record
	rm -rf .venv build .pytest_cache .ruff_cache .hypothesis *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
