#!/bin/bash
# Builds the image and tries it: command, output, demo, ranks, tests. Arguments go to pytest.
# With docker or podman where an engine answers; else, as root, with buildah, which needs none, over a base
# that debootstrap makes in ${XDG_CACHE_HOME:-~/.cache}/fenics-yeast.
set -euo pipefail
cd "$(dirname "$0")/.."

image=fenics-yeast base=debian:trixie-slim
cache=${XDG_CACHE_HOME:-$HOME/.cache}/fenics-yeast
scenes=$(mktemp --directory)
container=
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

build() { "$engine" build --tag "$image" --file docker/Dockerfile .; }
run() { "$engine" run --rm --volume "$scenes:/scenes" "$image" "$@"; }
size() { "$engine" images --format '{{.Size}}' "$image"; }

# What debian:trixie-slim is: a minimal tree without documentation and translations.
make_base() {
    local tree=$cache/debian13-base folder new
    if [ ! -d "$tree" ]; then
        mkdir -p "$cache"
        .ci/bootstrap "$tree"
    fi
    for folder in doc groff info lintian linda locale man; do
        rm -rf "$tree/usr/share/$folder"
        echo "path-exclude /usr/share/$folder/*"
    done > "$tree/etc/dpkg/dpkg.cfg.d/slim"
    new=$(buildah from scratch)
    buildah copy --quiet "$new" "$tree" / >/dev/null
    buildah run "$new" -- sh -c ': > /etc/apt/sources.list; rm -rf /var/lib/apt/lists/* /var/cache/apt/*.bin'
    buildah commit --quiet --rm "$new" "$base" >/dev/null
}

if docker info >/dev/null 2>&1; then
    engine=docker
elif podman info >/dev/null 2>&1; then
    engine=podman
elif command -v buildah >/dev/null && [ "$(id -u)" -eq 0 ]; then
    engine=buildah
    build() {
        buildah inspect --type image "$base" >/dev/null 2>&1 || make_base
        buildah bud --quiet --pull-never --network host --tag "$image" --file docker/Dockerfile \
            --volume "$cache/debian13-base/etc/apt/sources.list:/etc/apt/sources.list:ro" .
        container=$(buildah from --pull-never "$image")
    }
    run() { buildah run --network host --volume "$scenes:/scenes" "$container" -- entrypoint "$@"; }
else
    fail "neither docker nor podman answers; as root, run: apt-get install buildah debootstrap"
fi

began=$(now)
build
say "built with $engine in $(since "$began"), $(size)"

cp demos/scenes/bud.toml "$scenes"
[ "$(id -u)" -ne 0 ] || chown -R 12345:12345 "$scenes"  # the caller's, who need not be root
for start in first second; do
    began=$(now)
    run run bud.toml
    say "$start run in $(since "$began")"
done
[ "$(stat -c %u:%g "$scenes/out/bud/history.csv")" = "$(stat -c %u:%g "$scenes")" ] ||
    fail "the output is not the caller's"
short=(bud.toml --quiet --set run.end=5 --set 'run.save=[5]')
run run "${short[@]}" --out one
run mpirun -n 2 fenics-yeast run "${short[@]}" --out two
run python -c '
import csv
one, two = ([float(row["volume_ratio"]) for row in csv.DictReader(open(f"{name}/history.csv"))] for name in ("one", "two"))
assert len(one) > 20 and max(abs(a - b) for a, b in zip(one, two, strict=True)) < 1e-9
'
run python /opt/fenics-yeast/demos/fig4_bud.py
run pytest "$@"
say "passed"
