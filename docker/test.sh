#!/bin/bash
# Builds the image and tries it: command, output, demo, ranks, a sweep by compose, tests. Arguments go to pytest.
# With docker or podman where an engine answers; else, as root, with buildah, which needs none. Where no registry
# answers, and no older base is here, debootstrap makes the base, as root, in ${XDG_CACHE_HOME:-~/.cache}/fenics-yeast.
set -euo pipefail
cd "$(dirname "$0")/.."

image=fenics-yeast base=debian:trixie-slim
tree=${XDG_CACHE_HOME:-$HOME/.cache}/fenics-yeast/debian13-base
scenes=$(mktemp --directory)
container= compose=()
export STORAGE_DRIVER=${STORAGE_DRIVER:-vfs} BUILDAH_ISOLATION=chroot  # for buildah
finish() {
    rm -rf "$scenes"
    [ -z "$container" ] || buildah rm "$container" >/dev/null
}
trap finish EXIT

say() { echo "container: $1"; }
fail() { say "$1" >&2; exit 1; }
now() { echo "${EPOCHREALTIME/[.,]/}"; }  # in µs
since() { local past=$(($(now) - $1)); echo "$((past / 1000000)).$((past / 100000 % 10)) s"; }

load_base() { tar --create --directory "$tree" . | "$engine" import - "$base" >/dev/null; }
build() { "$engine" build --network host --build-arg BASE="$base" --tag "$image" --file docker/Dockerfile .; }
run() { "$engine" run --rm --volume "$scenes:/scenes" "$image" "$@"; }
size() { "$engine" images --format '{{.Size}}' "$image"; }

if docker info >/dev/null 2>&1; then
    engine=docker
    if docker compose version >/dev/null 2>&1; then
        compose=(docker compose)
    elif command -v docker-compose >/dev/null; then
        compose=(docker-compose)
    fi
elif command -v podman >/dev/null && podman info >/dev/null 2>&1; then
    engine=podman
    if command -v podman-compose >/dev/null; then
        compose=(podman-compose)
    fi
elif [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
    engine=buildah
    make --silent debian-packages PACKAGES=buildah
    load_base() {
        local new
        new=$(buildah from scratch)
        buildah copy --quiet "$new" "$tree" / >/dev/null
        buildah commit --quiet --rm "$new" "$base" >/dev/null
    }
    build() {
        buildah bud --pull-never --network host --build-arg BASE="$base" --tag "$image" \
            --file docker/Dockerfile . && container=$(buildah from --pull-never "$image")
    }
    run() { buildah run --network host --volume "$scenes:/scenes" "$container" -- entrypoint "$@"; }
else
    fail "neither docker nor podman answers; on Debian, root can build the image without them"
fi

# What debian:trixie-slim is: a minimal tree without documentation and translations.
make_base() {
    local folder fat=$tree-fat
    if [ ! -d "$tree" ]; then
        [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null || fail "only root of a Debian can make $base"
        mkdir -p "$(dirname "$tree")"
        rm -rf --one-file-system "$fat"
        .ci/bootstrap "$fat"
        for folder in doc groff info lintian linda locale man; do
            rm -rf "$fat/usr/share/$folder"
            echo "path-exclude /usr/share/$folder/*"
        done > "$fat/etc/dpkg/dpkg.cfg.d/slim"
        rm -rf "$fat"/var/lib/apt/lists/* "$fat"/var/cache/apt/*.bin
        mv "$fat" "$tree"
    fi
    base=fenics-yeast-base
    "$engine" inspect --type image "$base" >/dev/null 2>&1 || load_base
}

timeout 300 "$engine" pull "$base" >/dev/null 2>&1 || "$engine" inspect --type image "$base" >/dev/null 2>&1 || {
    say "no registry has $base for $engine: its base comes from debootstrap"
    make_base
}

began=$(now) log=$(mktemp)
build > "$log" 2>&1 || { tail -n 30 "$log" >&2; fail "the image cannot be built (all of it: $log)"; }
rm -f "$log"
say "built with $engine in $(since "$began"), $(size)"

cp demos/scenes/bud.toml "$scenes"
[ "$(id -u)" -ne 0 ] || chown -R 12345:12345 "$scenes"  # the caller's, who need not be root
start="first run"
if [ -w /proc/sys/vm/drop_caches ]; then
    sync
    echo 3 > /proc/sys/vm/drop_caches
    start="run with nothing in memory"
fi
for start in "$start" "run after that"; do
    began=$(now)
    run run bud.toml
    say "$start: $(since "$began")"
done
run new mine.toml
run run mine.toml --quiet
run python -c '
import json
for name in ("bud", "mine"):
    seconds = json.load(open(f"out/{name}/run.json"))["timings"]["compile_s"]
    assert seconds < 1, f"{name}: forms were compiled at run time, {seconds} s"
'
short=(bud.toml --quiet --set run.end=5 --set 'run.save=[5]')
run run "${short[@]}" --out one
run mpirun -n 2 fenics-yeast run "${short[@]}" --out two
run python -c '
import csv
one, two = ([float(row["volume_ratio"]) for row in csv.DictReader(open(f"{name}/history.csv"))] for name in ("one", "two"))
assert len(one) > 20 and max(abs(a - b) for a, b in zip(one, two, strict=True)) < 1e-9
'
run python /opt/fenics-yeast/demos/fig4_bud.py

values="growth.threshold=1 MPa,1.1 MPa" file=$PWD/docker/compose.yaml
if [ ${#compose[@]} -gt 0 ]; then
    (
        cd "$scenes"
        RANKS=3 VARY=$values "${compose[@]}" --file "$file" run --rm -T sweep
        "${compose[@]}" --file "$file" down
    )
else
    say "compose is not tried: there is none for $engine"
    run mpirun -n 3 fenics-yeast sweep bud.toml --vary "$values"
fi
[ "$(grep --count finished "$scenes/out/bud-sweep/sweep.csv")" = 2 ] || fail "the sweep lacks a case"
[ -z "$(find "$scenes" ! -user "$(stat -c %u "$scenes")")" ] || fail "the output is not the caller's"
run pytest "$@"
say "passed"
