# Two commands for a user: `make demo` and `make test`. Both make their own environment first.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed

# Hundreds of short processes: each would compile the sources anew where this is set.
unexport PYTHONDONTWRITEBYTECODE

GAP    := runs/reality-gap
TWIN   := scenarios/models/surrogate.toml

.PHONY: interop demo demo-gap demo-campaign test lint types contract compiled-drive compiled-gap collected unit wheel mutants mutation stages gate-power real-time nightly conformance reliability bench blind campaigns licences ads-report paper paper-twins paper-searches paper-kills clean

# uv installs the same versions in a tenth of the time; where it cannot (another index, no wheel of it), pip does.
$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	{ $(BIN)/python -m pip install -q -c constraints.txt uv && $(BIN)/uv pip install -q -p $(BIN)/python -c constraints.txt -e '.[dev]'; } \
	    || $(BIN)/python -m pip install -q -c constraints.txt -e '.[dev]'
	touch $@

demo: $(STAMP)
	$(BIN)/dvp run scenarios/overtaking.xosc scenarios/pedestrian_crossing.xosc scenarios/urban.xosc
	@$(MAKE) --no-print-directory demo-gap
	@$(MAKE) --no-print-directory demo-campaign

# A stack that looks only 2.6 m to each side: where in the ranges of the scenario it fails, as a picture, and one small
# scenario for each kind of failure. A campaign that finds failures exits with 1, which is what it is for here.
demo-campaign: $(STAMP)
	$(BIN)/dvp campaign scenarios/overtaking.xosc --out runs/campaign --runs 60 --set P.LIDAR_abs_y_max=2.6 || test $$? -eq 1

# The surrogate drives with an effect hidden in it (edit $(GAP)/hidden.toml and run again). A twin from its data sheet
# lacks that, and all else that no maker prints; from the logs alone it learns what, and the error on the drive that
# nothing was fitted on falls. Whatever the diagnosis names is added, also what is provisional. Two to three minutes of CPU.
demo-gap: $(STAMP) $(GAP)/hidden.toml
	$(BIN)/python -m vehicle.surrogate --drive urban --seed 2 --hidden $(GAP)/hidden.toml --out $(GAP)/urban.csv
	$(BIN)/python -m vehicle.surrogate --drive rich --seed 1 --hidden $(GAP)/hidden.toml --out $(GAP)/rich.csv
	$(BIN)/dvp compare $(GAP)/urban.csv --model $(TWIN)
	$(BIN)/dvp diagnose $(GAP)/rich.csv --held-out $(GAP)/urban.csv --model $(TWIN) --report $(GAP)/diagnosis.html \
	    > $(GAP)/diagnosis.txt; cat $(GAP)/diagnosis.txt
	$(BIN)/dvp extend --model $(TWIN) --fit $(GAP)/rich.csv --held-out $(GAP)/urban.csv --out $(GAP)/extended.toml \
	    --add $$(sed -n 's/^  [+~] \([a-z_]*\) .*/\1/p' $(GAP)/diagnosis.txt | awk '!seen[$$0]++')
	$(BIN)/dvp compare $(GAP)/urban.csv --model $(GAP)/extended.toml

$(GAP)/hidden.toml:
	mkdir -p $(GAP)
	printf '[hidden.steer_delay]\nT = 0.25\n' > $@

test: $(STAMP)
	@$(MAKE) --no-print-directory -j2 --output-sync=target compiled-drive lint types contract compiled-gap collected
	@$(MAKE) --no-print-directory unit

# What numba compiles, once: two test workers that begin cold would both do it. After an edit this compiles what the edit
# has changed, wherever it is called from (machine_code/). A drive takes one core for as long as the checks and the gap
# take the other.
compiled-drive: $(STAMP)
	$(BIN)/dvp run scenarios/overtaking.xosc --no-report
	$(BIN)/python -m benchmarks.arch_comp --problem AT1 --problem CC1 --method random --repeats 1 --budget 1 > /dev/null

compiled-gap: $(STAMP)
	mkdir -p runs
	$(BIN)/python -m vehicle.surrogate --drive urban --out runs/compiled.csv
	$(BIN)/dvp diagnose runs/compiled.csv --model tests/truth/surrogate_inside.toml

# pytest rewrites the asserts of each test file and keeps what it wrote: 20 s that each worker would spend.
collected: $(STAMP)
	$(BIN)/python -m pytest -qq --collect-only tests scenarios > /dev/null || true  # `unit` tells what is wrong

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

contract: $(STAMP)
	$(BIN)/lint-imports

# A file stays with one worker: what its tests share, such as a drive or a process, is then made once. Two workers
# on two cores: a third would save some waiting, and cost a tenth more of CPU. Each simulates in one thread.
unit: $(STAMP)
	NUMBA_NUM_THREADS=1 $(BIN)/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder tests scenarios

# Builds sdist and wheel into dist/, and tries the wheel in an empty environment from an empty folder. Minutes, most of
# them to install and to compile, so it is no part of `make test`, which only compares the lists of files.
wheel: $(STAMP)
	$(BIN)/python -m scripts.try_wheel

# All tests, also those marked `nightly`. More than an hour, most of it what `make test` does with 400 mutated scenarios,
# 150 roads and 750 random elements, with 100,000 of each. Killed, it goes on where it was (runs/fuzz); DVP_FUZZ=10000 takes fewer. Then 12 variants of each
# scenario, 100 drives for the filter's own accuracy, a hidden effect of each kind, every fault seeded into the reference
# stack, and 1,000 seeds of the stack as it is. `make test` takes a few of each.
nightly: $(STAMP)
	DVP_NIGHTLY=1 DVP_FUZZ=$${DVP_FUZZ:-100000} DVP_VARIANTS=$${DVP_VARIANTS:-12} DVP_CASES=10000 DVP_NEES=100 \
	    DVP_MATRIX=all DVP_FAULTS=all DVP_CLEAN_SEEDS=$${DVP_CLEAN_SEEDS:-1000} \
	    $(BIN)/python -m pytest -q -n 2 --dist loadfile --no-loadscope-reorder tests scenarios

# The same scenarios on the surrogate car over ROS 2 messages, then the gates between stages: they pass with the twin that
# learnt from the car's logs, and fail with every wrong one (writes docs/stages.md); once more with its drive-by-wire on CAN.
# Half an hour.
stages: $(STAMP)
	$(BIN)/python -m pytest -q -n 2 -m "pe or rw" scenarios
	$(BIN)/python -m scripts.stage_twins
	$(BIN)/python -m pytest -q -n 2 -m "pe or rw" scenarios --dvp-vehicle can
	$(BIN)/python -m scripts.stage_twins --wire can
	DVP_STAGES=all $(BIN)/python -m pytest -q tests/unit/harness/test_gates_between_stages.py

# What each gate between stages catches: wrong twins, and how often it fails the right one (writes docs/stages.md).
# Eleven minutes of CPU; drives are kept.
gate-power: $(STAMP)
	$(BIN)/python -m scripts.gate_power

# By the wall clock: deadlines, round trips, and how soon a dead car is noticed; writes docs/your-vehicle.md.
real-time: $(STAMP)
	$(BIN)/python -m scripts.real_time

# Every message of the wire to a peer of another make and back: Fast DDS in C++, and ROS 1 with its roscore. Debian has both.
interop: $(STAMP)
	@[ -d /usr/include/fastdds ] || { [ "$$(id -u)" = 0 ] && apt-get install -y -qq g++ libfastrtps-dev >/dev/null; } || true
	@command -v rosmaster >/dev/null || { [ "$$(id -u)" = 0 ] && apt-get install -y -qq --no-install-recommends ros-core python3-rospy >/dev/null; } || true
	DVP_INTEROP=1 $(BIN)/python -m pytest -q -rs tests/interop

# All reference trajectories, storyboard events and roads; writes docs/conformance.md.
conformance: $(STAMP)
	$(BIN)/python -m scripts.conformance --least 0.95
	$(BIN)/python -m pytest -q tests/conformance/test_roads.py

# Measures every figure of the reference stack anew and writes docs/ads.md; minutes.
ads-report: $(STAMP)
	$(BIN)/python -m scripts.ads_report

bench: $(STAMP)
	$(BIN)/python -m benchmarks

# The guard: coverage, every mutant, a million commands, its states; writes its part of docs/reliability.md.
reliability: $(STAMP)
	$(BIN)/python -m scripts.make_reliability_page

# 600 mutants of what compares, diagnoses, judges and drives, and the share of them that the tests notice; hours, so
# MINUTES=35 ends sooner, and the next call goes on where it was. Figures and survivors stand in docs/quality.md.
mutants: $(STAMP)
	nice $(BIN)/python -m scripts.mutants --minutes $${MINUTES:-inf}

# Faults drawn by SEED, the commit that froze the gates, put into the reference stack under the gates that ship, and
# drives with new seeds; both go on where they were. An hour of CPU; figures stand in docs/mutate.md.
mutation: $(STAMP)
	$(BIN)/python -m scripts.shipped_drives clean 0 90
	for kinds in first second source; do \
	    $(BIN)/python -m scripts.fault_drives drive $(SEED) --kinds $$kinds --count 60 || exit 1; \
	    $(BIN)/python -m scripts.fault_drives tell $(SEED) --kinds $$kinds || exit 1; \
	done
	$(BIN)/python -m scripts.shipped_drives fresh 4000 4240

blind: $(STAMP)
	$(BIN)/python -m scripts.blind_answers $${DVP_SHARED:-../shared}/blind

# The paper's method on four surrogate cars, its result table beside ours: writes docs/mcrpg.md. The nominal car took 42
# minutes of CPU (`make paper CARS=nominal`); killed, it goes on where it was.
paper: $(STAMP)
	$(BIN)/python -m scripts.mcrpg_page paper $(CARS)

# Only what the logs of each car make of the bare data sheet, without tuning: a few minutes of CPU a car.
paper-twins: $(STAMP)
	$(BIN)/python -m scripts.paper_twins $(CARS)

paper-searches: $(STAMP)
	$(BIN)/python -m scripts.mcrpg_page searches

paper-kills: $(STAMP)
	$(BIN)/python -m scripts.mcrpg_page kills

# Figures of docs/campaigns.md: cost of a drive, a planted rare fault by chance and by searches, coverage of intervals, and
# 200 kills of command, workers and scheduler at random times.
campaigns: $(STAMP)
	$(BIN)/python -m scripts.campaign_figures cost
	$(BIN)/python -m scripts.campaign_figures chance 3000
	for NAME in gaussian_process descent cross_entropy; do $(BIN)/python -m scripts.campaign_figures search $$NAME; done
	$(BIN)/python -m scripts.campaign_figures coverage 200 910000
	DVP_KILLS=200 $(BIN)/python -m pytest -q tests/unit/campaigns/test_campaign_kills.py

licences: $(STAMP)
	$(BIN)/python -m scripts.third_party_licences > THIRD_PARTY_LICENCES.md

clean:
	find . -name __pycache__ -not -path "./$(VENV)/*" -prune -exec rm -rf {} +
	rm -rf $(VENV) runs .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
