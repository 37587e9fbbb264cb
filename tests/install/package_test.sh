#!/bin/bash
# package_test.sh SOURCE_FOLDER [DEBS]: makes the packages (or takes those in DEBS), installs them with apt in an empty Debian 12, and there runs the
# demo and Python without a compiler. Needs root, mmdebstrap and the network: nightly. Exit code 77: skipped.
set -euo pipefail
source=$(realpath "$1")
command -v mmdebstrap >/dev/null || { echo "package: skipped: mmdebstrap is not installed"; exit 77; }
[[ $(id -u) -eq 0 ]] || { echo "package: skipped: needs root"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
debs=${2:-$work/debs}
[[ -n "${2:-}" ]] || "$source/tools/package" "$debs" >/dev/null
mmdebstrap --quiet --variant=apt bookworm "$work/root" http://deb.debian.org/debian
cp "$debs"/*.deb "$work/root/"
cp /etc/resolv.conf "$work/root/etc/"
inside() { chroot "$work/root" "$@"; }
inside sh -c 'apt-get update -qq && apt-get install -y -qq --no-install-recommends /patinate_*.deb /patinate-library_*.deb' >"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log"; exit 1; }
# The base alone, small: the library and a mesh of one's own; what is missing says which package has it.
mount -t proc proc "$work/root/proc"
trap 'umount "$work/root/proc" && rm -rf --one-file-system "$work"' EXIT
inside bash -c 'cd /root && patinate synth sculpture -o urn --quiet && patinate transfer library:rust urn/mesh.obj --unit mm --control accessibility --resolution 256 -o rusty --quiet && patinate render rusty -o rusty.png --quiet && test -s rusty.png'
said=$(inside bash -c 'cd /root && patinate render rusty -o rusty.jpg 2>&1 || true')
[[ "$said" == *"Debian's package patinate-media"* ]] || { echo "package: without patinate-media: $said"; exit 1; }
inside sh -c 'apt-get install -y -qq --no-install-recommends /*.deb' >"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log"; exit 1; }
if inside sh -c 'command -v gcc g++ cc cmake'; then echo "package: there is a compiler: nothing is shown"; exit 1; fi
inside patinate --version
for file in /usr/share/man/man1/patinate.1.gz /usr/share/bash-completion/completions/patinate /usr/share/doc/patinate/copyright /usr/share/doc/python3-patinate/copyright; do
  inside test -s "$file" || { echo "package: $file is missing"; exit 1; }
done
inside bash -c 'cd /root && time -p bash /usr/share/patinate/demo demo >/dev/null && test -s demo/index.html'
# The library, offline, on a mesh.
inside bash -c 'cd /root && patinate history library && patinate transfer library:rust demo/urn/mesh.obj --unit mm --control accessibility --resolution 256 -o rusty --quiet && patinate export rusty -o rusty.glb --quiet && test -s rusty.glb'
inside python3 -c '
import numpy as np, patinate
history = patinate.history_from_arrays(np.random.default_rng(1).random((2, 64, 64, 3), np.float32), [0, 1], controls={"x": np.linspace(0, 1, 4096, dtype=np.float32).reshape(64, 64)})
aged = patinate.transfer(history, patinate.read_mesh("/root/demo/urn/mesh.obj"), "facing", resolution=64)
patinate.write_color("/root/aged.jpg", aged.texture(1))  # By the module of image formats.
print(patinate.__version__, patinate.read_color("/root/aged.jpg").shape)
'
echo "1 passed, 0 failed"
