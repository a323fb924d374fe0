# Every target does its own set-up; if nothing is missing, this costs one dpkg-query call.
# Targets and prerequisites are relative names, so that the path may contain spaces.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

# Debian's dolfinx needs Debian's Python, even if another python3 comes first on PATH.
SYSTEM_PYTHON := /usr/bin/python3
# python3-dolfinx includes the C compiler, mpirun, NumPy and SciPy; pip installs the other libraries.
PACKAGES := python3-dolfinx python3-venv
PYTHON := .venv/bin/python
# More arguments for pytest: make test ARGS="-k sphere"
ARGS ?=
# Program that runs pytest, such as coverage.
MEASURED ?=

export PYTHONNOUSERSITE := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export OMP_NUM_THREADS := 1
# mpirun as root, with more ranks than cores (the PRTE names are those of Open MPI 5), through memory.
export OMPI_ALLOW_RUN_AS_ROOT := 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM := 1
export OMPI_MCA_rmaps_base_oversubscribe := 1
export OMPI_MCA_mpi_yield_when_idle := 1
# Without ofi, for which Open MPI 5 would search for a second.
export OMPI_MCA_btl := ^tcp,ofi
# Otherwise the ranks of all runs share the same first cores.
export OMPI_MCA_hwloc_base_binding_policy := none
export PRTE_MCA_hwloc_default_binding_policy := none
export PRTE_MCA_rmaps_default_mapping_policy := :oversubscribe

# A .venv works only in its directory and with its Python, which the stamp records.
ifneq "$(file <.venv/.installed)" "$(CURDIR) $(realpath $(SYSTEM_PYTHON))"
.venv/.installed: FORCE
endif

.PHONY: help
help:  ## print this list
	@echo "make TARGET, where TARGET is one of"
	@sed -nE 's/^([a-z0-9-]+):.*## (.*)/  \1\t\2/p' Makefile | expand -t 18

.PHONY: demo
demo: setup  ## the paper's budding cell: volumes, figures and data
	@.venv/bin/fenics-yeast run demos/scenes/bud.toml
	@echo "Figures: out/bud/figures/shapes.png, volume.png; data: out/bud/history.csv, profiles.npz"

.PHONY: test
test: .venv/.installed-test  ## all tests; ARGS="..." goes to pytest
	@$(PYTHON) $(MEASURED) -m pytest $(ARGS)

.PHONY: test-fast
test-fast: .venv/.installed-test  ## the tests that take less than a minute
	@$(PYTHON) $(MEASURED) -m pytest -m "not slow and not process and not ranks" $(ARGS)

# A sixteenth of N scenes is run, which takes as long as to read the others.
.PHONY: fuzz
fuzz: .venv/.installed-test  ## N random scenes (2000 by default), other ones at each call
	@FUZZ=$(or $(N),2000) $(PYTHON) -m pytest tests/properties $(ARGS)

.PHONY: test-ranks
test-ranks: .venv/.installed-test  ## tests marked `distributed`, on two and three ranks
	@for n in 2 3; do \
	    timeout 600 mpirun -n $$n $(PYTHON) -m pytest --color=no -m distributed $(ARGS) || \
	        { echo "error: the tests failed on $$n ranks" >&2; exit 1; }; \
	done

.PHONY: test-debian13
test-debian13:  ## demo and tests on Debian 13, in a tree of its own (needs root; ARGS as above)
	@.ci/debian13 $(ARGS)

.PHONY: test-container
test-container:  ## build and test the image (docker, podman, or as root buildah; ARGS as above)
	@docker/test.sh $(ARGS)

.PHONY: package
package: .venv/.installed-dev  ## sdist and wheel in dist/, each tested in a clean environment
	@.ci/package

.PHONY: coverage
coverage: .venv/.installed-dev  ## all tests, and the lines that they miss
	@status=0; $(MAKE) --no-print-directory test MEASURED="-m coverage run" || status=$$?; \
	$(PYTHON) -m coverage report --skip-covered --show-missing; exit $$status

.PHONY: lint
lint: .venv/.installed-dev  ## style, format and types
	@$(PYTHON) -m ruff check
	@$(PYTHON) -m ruff format --check
	@$(PYTHON) -m mypy

.PHONY: bench
bench: setup  ## run times
	@for script in demos/benchmarks/*.py; do $(PYTHON) "$$script"; done

.PHONY: clean
clean:  ## remove results, caches and builds (the set-up in .venv stays)
	@rm -rf out build dist htmlcov .coverage .coverage.* .mypy_cache .pytest_cache .ruff_cache
	@find . -path ./.venv -prune -o -type d \( -name __pycache__ -o -name '*.egg-info' \) \
	    -prune -exec rm -rf {} +

.PHONY: setup
setup: .venv/.installed  ## Debian packages and .venv, if missing or out of date

.venv/.installed: pyproject.toml | debian-packages
	@echo "Setting up .venv (under a minute)"
	@$(SYSTEM_PYTHON) -c 'import dolfinx' || \
	    { echo "error: dolfinx cannot be imported; run: apt-get install --reinstall $(PACKAGES)" >&2; exit 1; }
	@$(SYSTEM_PYTHON) -m venv --system-site-packages .venv
	@# Packages in ~/.local must not be used either, when the command is called without make.
	@echo 'import site; site.ENABLE_USER_SITE = False' \
	    > "$$($(PYTHON) -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/no_user_site.pth"
	@# petsc4py and dolfinx are built for Debian's NumPy, which pip must not replace.
	@$(SYSTEM_PYTHON) -c 'import numpy; print(f"numpy=={numpy.__version__}")' > .venv/constraints.txt
	@$(call pip-install,.)
	@echo "$$(pwd -P) $$(readlink -f $(SYSTEM_PYTHON))" > $@

.venv/.installed-test: .venv/.installed
	@echo "Installing the test libraries in .venv (100 MB, mostly VTK)"
	@$(call pip-install,.[test])
	@touch $@

.venv/.installed-dev: .venv/.installed-test
	@echo "Installing the development tools in .venv"
	@$(call pip-install,.[test$(comma)dev])
	@touch $@

comma := ,
define pip-install
$(PYTHON) -m pip install --quiet --constraint .venv/constraints.txt --editable '$(1)' || \
    { echo "error: pip could not install the libraries; check that PyPI can be reached, then run make again" >&2; exit 1; }
endef

.PHONY: debian-packages
debian-packages:
	@installed=$$(dpkg-query --show --showformat '$${db:Status-Status}\n' $(PACKAGES) 2>/dev/null \
	    | grep -cx installed) || true; \
	if [ "$${installed:-0}" -eq $(words $(PACKAGES)) ]; then exit 0; fi; \
	fail() { echo "error: $$1; as root, run: apt-get update && apt-get install $(PACKAGES)" >&2; exit 1; }; \
	command -v apt-get >/dev/null || \
	    { echo "error: apt-get is missing; fenics-yeast needs Debian 12 or 13 with $(PACKAGES)" >&2; exit 1; }; \
	if [ "$$(id -u)" -eq 0 ]; then root=; else root=sudo; \
	    command -v sudo >/dev/null || fail "Debian packages and sudo are missing"; fi; \
	echo "Installing from Debian: $(PACKAGES), and what they need (minutes)"; \
	log=$$(mktemp); apt="$$root env DEBIAN_FRONTEND=noninteractive apt-get --quiet --option DPkg::Lock::Timeout=300"; \
	{ $$apt --error-on=any update || apt="$$apt --option Acquire::Retries=0"; \
	    $$apt install --yes --no-install-recommends $(PACKAGES); } > "$$log" 2>&1 || \
	    { tail -n 5 "$$log" >&2; \
	    fail "the Debian packages could not be installed; check the network (log of apt: $$log)"; }; \
	rm -f "$$log"

.PHONY: FORCE
FORCE:
