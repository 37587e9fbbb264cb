#!/bin/sh
# run.sh OUTPUT_TEST - writes sample GLB files with our test program and validates them.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
PATINATE_GLTF_SAMPLES="$folder" "$1" --gtest_filter=Glb.SampleForTheKhronosValidator >/dev/null
node "$here/validate.mjs" "$folder"/*.glb
