# Two commands do everything on a fresh machine with Python 3.11 or newer: `make validate` and `make test`.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
ENGINE_SCENES ?= shear-press saw-40rpm saw-500rpm cam-follower crank-shaper whitworth six-bar planetary-gear
MUTANT_SECONDS ?= 3600 # after which `make mutants` stops; the next one goes on from there
SPACE_STEPS ?= [25,50,100,200,400,800,1600]
SHORT_STEPS ?= [25,50,100,200] # of Newton, whose steps cost milliseconds
SPACE_ENGINES ?= 'mujoco','exudyn','drake','rapier'
MUTANT_SAMPLE ?= 20 # defects of a module at most, those of changed functions first; 0 for all
READY  := $(VENV)/.ready
LOWEST ?= .venv-lowest
# The tests start hundreds of interpreters; without bytecode files each would compile conrod again.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: validate catalogue space sweep engines prior limits ablate versions audit cams batch detection stale inputs own-models reports verification test test-all lowest lint types mjcf pymunk-models golden golden-write bench mutants attack wheel try-wheel release notebooks site check environments clean

validate: $(READY) catalogue ## compare both engines with the exact motion on all scenes, and rewrite reports/
	$(BIN)/conrod validate --fresh --out reports

catalogue: $(READY) ## the same for the machines of the catalogue: rewrite reports/catalogue/ and the page on them
	$(BIN)/conrod validate catalogue --fresh --out reports/catalogue
	$(BIN)/python docs/catalogue.py > docs/catalogue.md

space: $(READY) ## the machines in space, in MuJoCo (status 1: out of tolerance as they are), and all engines beside each other: rewrite reports/space/
	$(BIN)/conrod validate spatial --tolerance position=0.1mm --out reports/space || test $$? = 1
	$(BIN)/python -c "import conrod; conrod.validate_in_space(engines=[$(SPACE_ENGINES)], steps_per_rev=$(SPACE_STEPS), revolutions=1).write('reports/space')"
	if $(BIN)/python -c "import newton" 2> /dev/null; then \
	    $(BIN)/python -c "import conrod; conrod.validate_in_space(engines=['newton'], steps_per_rev=$(SHORT_STEPS), revolutions=1).write('reports/space')"; fi

sweep: $(READY) ## measure speed against accuracy and rewrite reports/sweep/; an hour, can be interrupted
	$(BIN)/conrod sweep cam-follower --grid coarse --out reports/sweep
	$(BIN)/conrod sweep shear-press saw-40rpm saw-500rpm --out reports/sweep
	$(MAKE) prior

engines: $(READY) ## engines beside each other, all that are installed: rewrite reports/engines/; half an hour, on an idle machine
	$(BIN)/conrod sweep $(ENGINE_SCENES) --grid presets --engine all --out reports/engines

prior: $(READY) ## rewrite the table that `conrod recommend` starts from, from reports/sweep/
	$(BIN)/python -m benchmarks.prior reports/sweep/data/*.json > prior.json
	mv prior.json src/conrod/studies/sweep/prior.json

limits: $(READY) ## find where the engines stop being trustworthy and rewrite reports/limits/; hours, can be interrupted
	$(BIN)/conrod limits shear-press saw-500rpm cam-follower --out reports/limits
	for run in "mujoco --preset hardened" "pymunk --preset tuned"; do \
	    $(BIN)/conrod limits saw-500rpm --axis run-length --engine $$run --range 1..1000000 --cell-timeout 20000 \
	        --out reports/limits || exit; done

ablate: $(READY) ## measure what a model requires, and rewrite reports/ablate/; on an idle machine
	$(BIN)/conrod ablate shear-press saw-500rpm cam-follower --out reports/ablate

versions: $(READY) ## measure what each release of the engines changed, and rewrite reports/versions/; half an hour, needs a network
	for engine in pymunk mujoco; do $(BIN)/conrod versions $$engine --out reports/versions || exit; done

audit: $(READY) ## check the documents' printed numbers and formulas against the exact motion, and rewrite reports/audit/
	$(BIN)/python -m audits --out reports/audit

cams: $(READY) ## all 25 cams of document 004 in both engines, with its figures: rewrite reports/cams/; some minutes
	$(BIN)/python -m audits.cams --out reports/cams

batch: $(READY) ## a thousand saws of a drawing's tolerances in one call of MJX: rewrite reports/batch/; ten minutes
	$(BIN)/python -m docs.studies.batch --out reports/batch

test: $(READY) ## the fast tests, some minutes on two cores
	$(BIN)/python -m pytest -n auto

test-all: $(READY) ## the slow tests too: all 25 cams, long runs
	$(BIN)/python -m pytest -n auto -m "slow or not slow"

# What its libraries warn of each other is not conrod's: newer ones have deprecated what these call.
lowest: $(LOWEST)/.ready ## the tests of command line, runs and engines with the lowest versions that are allowed
	$(LOWEST)/bin/python -m pytest -n auto -W ignore::DeprecationWarning tests/cli tests/comparison tests/engines \
	    tests/mechanism tests/exact/test_exact_dynamics.py

lint: $(READY)
	$(BIN)/ruff check src audits tests benchmarks docs/studies docs/committed_models.py
	$(BIN)/ruff format --check src audits tests benchmarks docs/studies docs/committed_models.py

types: $(READY)
	$(BIN)/mypy

mjcf: $(READY) ## rewrite the committed MuJoCo models of all machines
	$(BIN)/python -m docs.committed_models mjcf

pymunk-models: $(READY) ## rewrite the committed Python modules that build all machines in pymunk
	$(BIN)/python -m docs.committed_models pymunk

detection: $(READY) ## how small a defect the verdicts notice, and false alarms: rewrite reports/detection/; an hour, can be interrupted
	$(BIN)/python -m docs.studies.detection --out reports/detection

stale: $(READY) ## what of the committed reports is out of date: some runs of each made again, SECONDS of CPU in all [60]
	$(BIN)/python -m docs.studies.stale --seconds $(or $(SECONDS),60) $(if $(SEED),--seed $(SEED))

inputs: $(READY) ## 200 inputs of ten kinds, half of them wrong: are causes named? Rewrites the table in docs/detection.md; ten minutes
	$(BIN)/python -m docs.studies.inputs --write docs/detection.md

own-models: $(READY) ## closed loops of robots in the folder MODELS, see reports/own-models/README.md; minutes for each of them
	$(BIN)/python -m docs.studies.own_models $(MODELS) $(if $(ROBOTS),--only $(ROBOTS))

# In its folder, since a report has the names of files; without the earlier reports, which would begin a record of changes.
reports: $(READY) ## every report of this repository anew, what times steps last; goes on where it was stopped. ONLY="limits sweep", LIST=--list
	$(BIN)/python -m docs.studies.all_reports $(LIST) $(ONLY)

verification: $(READY) ## the examples of verification reports: rewrite reports/verification/
	cd reports/verification && rm -f *.html && $(abspath $(BIN))/conrod validate saw-500rpm --limits ../limits --verification saw-500rpm.html
	cd reports/verification && $(abspath $(BIN))/conrod check inputs/hacksaw.xml --scene saw-40rpm --crank motor --point C=body:bow \
	    --point M=geom:rod --tolerance position=2e-3 --measured inputs/encoder.csv --uncertainty rod=0.05mm --uncertainty crank=0.02mm \
	    --uncertainty offset=0.05mm --uncertainty measured=0.01mm --verification hacksaw.html

golden: $(READY) ## compare today's results with the golden ones, to 1e-13: after a change that should change none
	$(BIN)/python -m tests.golden check

golden-write: $(READY) ## make today's results the golden ones, of the groups named: make golden-write GROUPS="scenes limits"
	$(BIN)/python -m tests.golden write $(GROUPS)

bench: $(READY) ## measure what conrod itself costs, see docs/benchmarks.md; an estimated 20 minutes on two idle cores
	$(BIN)/python -m benchmarks

mutants: $(READY) ## plant defects where verdicts are made, and fail where the tests find fewer than 95 %; docs/mutants.md
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev,engines,mutants]'
	$(BIN)/python tests/support/sampled_mutants.py --seconds $(MUTANT_SECONDS) --sample $(MUTANT_SAMPLE)
	$(BIN)/python tests/support/killed_mutants.py mutants/mutants/src

attack: $(READY) ## kills, mutated files, planted faults; docs/attack.md. Another SEED tries others; goes on where it was stopped
	CONROD_ATTACK_SEED=$(or $(SEED),1) CONROD_ATTACK_SECONDS=$(or $(SECONDS_OF_CPU),900) $(BIN)/python -m pytest -q -rs -m slow tests/attack

notebooks: $(READY) ## run the notebooks in examples/ and write their pages, with what they print; half a minute
	$(BIN)/python docs/notebooks.py

site: $(READY) ## the committed results and pages as a site of HTML files in site/
	$(BIN)/python docs/site.py site

wheel: $(READY)
	$(BIN)/python -m build --wheel --outdir dist

try-wheel: wheel ## install the wheel in a folder of its own and validate a machine with it
	.ci/try_wheel dist/conrod-*.whl

release: $(READY) ## what is uploaded to a package index, built and tried: docs/releasing.md
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt 'twine>=6.1'
	$(BIN)/python -m twine check --strict dist/*
	.ci/try_wheel dist/conrod-*.whl

check: lint types test

environments: $(READY) $(LOWEST)/.ready ## all that is installed for the tests

clean:
	rm -rf $(VENV) $(LOWEST) dist build

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit("conrod needs Python 3.11 or newer, this is " + sys.version.split()[0] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --constraint constraints.txt --editable '.[dev,engines]'
	touch $(READY)

$(LOWEST)/.ready: pyproject.toml constraints-lowest.txt
	$(PYTHON) -m venv $(LOWEST)
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints-lowest.txt --editable '.[box2d,dev,drake,exudyn,fmi]'
	touch $@
