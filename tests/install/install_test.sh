#!/bin/bash
# install_test.sh BUILD_FOLDER SOURCE_FOLDER: installs into a fresh prefix and asks for three components alone. With PATINATE_NIGHTLY for every
# component, and builds docs/examples against what is installed as a stranger would, and runs every example.
set -euo pipefail
build=$1
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Compiled under a fresh path every time: ccache knows it again by what lies below it.
export CCACHE_BASEDIR="$work" CCACHE_NOHASHDIR=1
cmake --install "$build" --prefix "$work/prefix" >/dev/null
python3 "$source/tests/install/components_test.py" "$source" "$work/prefix" "$work"
patinate="$work/prefix/bin/patinate"
"$patinate" --version
for said in man/man1/patinate.1.gz bash-completion/completions/patinate zsh/vendor-completions/_patinate fish/vendor_completions.d/patinate.fish; do
  [[ -s "$work/prefix/share/$said" ]] || { echo "install: share/$said is missing or empty"; exit 1; }
done
if [[ -z "${PATINATE_NIGHTLY:-}" ]]; then
  echo "1 passed, 0 failed"
  exit
fi

cp -r "$source/docs/examples" "$work/source"
configure=(-G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER="$(command -v ccache || true)")
cmake -S "$work/source" -B "$work/examples" "${configure[@]}" >/dev/null
cmake --build "$work/examples" >"$work/log" || { cat "$work/log"; exit 1; }

cd "$work"
"$work/examples/03_full_control" texture.png picture.png
"$patinate" synth crackle --width 192 --height 192 --num-frames 6 -o crackle --quiet
"$patinate" ingest crackle -o history --quiet
"$patinate" synth sculpture --resolution 48 -o urn --quiet
"$work/examples/02_own_control" history urn/mesh.obj own.png
"$work/examples/01_one_call" history urn/mesh.obj facing aged one.png
"$patinate" lookup aged --time 1 -o looked_up.png --quiet
"$work/examples/04_simulate" ledge
"$work/examples/05_capture" photographs captured
"$work/examples/06_compare"
# Formats that the modules bring: installed beside the programs, and found by a program of a stranger's.
"$work/examples/02_own_control" history urn/mesh.obj own.jpg
"$patinate" export history -o film.gif --frames 3 --quiet
for picture in own.png own.jpg film.gif one.png looked_up.png texture.png picture.png ledge/color.png ledge/hits.exr; do
  said=$("$patinate" info "$picture" --json)
  [[ "$said" == *'"kind": "image"'* ]] || { echo "install: $picture is no picture: $said"; exit 1; }
done
echo "1 passed, 0 failed"
