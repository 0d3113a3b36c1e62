#!/bin/sh
# Whether presets bring the Khronos validator to say anything about models that it did not say before.
#
#   tests/validate.sh PRESET MODEL.. [-- PRESET MODEL..]..
#
# NODE_HOME names a folder with node_modules in which gltf-validator is (`npm install gltf-validator@2.0.0-dev.3.10`); without
# it, or without node, nothing is looked at. WIREWORK is the command, by default target/debug/wirework.
set -u
here=$(CDPATH='' cd "$(dirname "$0")" && pwd)
command=${WIREWORK:-$here/../target/debug/wirework}
if ! command -v node >/dev/null || [ ! -d "${NODE_HOME:-}/node_modules/gltf-validator" ]; then
    echo "skipped: node, or gltf-validator in NODE_HOME, is not there" >&2
    exit 0
fi
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
fail=0 preset=''
for argument in "$@"; do
    if [ "$argument" = -- ]; then preset=''; continue; fi
    if [ -z "$preset" ]; then preset=$argument; continue; fi
    for out in out.glb out.gltf still.glb; do
        set -- --fps 8
        [ "$out" = still.glb ] && set -- --at 0.5
        rm -rf "$place/out" && mkdir "$place/out"
        "$command" apply "$preset" "$argument" -o "$place/out/$out" -q "$@" || { fail=1; continue; }
        node "$here/validate.mjs" "$argument" "$place/out/$out" || { echo "$preset: $argument: $out" >&2; fail=1; }
    done
done
exit $fail
