"""`pip install .` (PEP 517) and `pip install -e .` (PEP 660): CMake compiles, and a wheel takes the module and the programs that it starts, or names where they
were built. It needs no other package."""
import base64
import gzip
import hashlib
import io
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAMS = ("patinate", "patinate-media", "patinate-pcl", "patinate-draco", "patinate-markers", "patinate-decode")
COMPONENTS = ("python", "runtime", "media", "markers", "pcl", "library")


def run(*command):
    if subprocess.run([*map(str, command)], cwd=ROOT, stdout=sys.stderr).returncode != 0:
        raise SystemExit(f"patinate: `{' '.join(map(str, command))}` failed; tools/setup installs what is missing")


def built_folder():
    """The finished build: the one that $PATINATE_BUILD names, or the one of the release preset, made here."""
    if given := os.environ.get("PATINATE_BUILD"):
        return pathlib.Path(given)
    folder = ROOT / "build/release"
    run("cmake", "--preset", "release", "-DPATINATE_PYTHON=ON", *([] if (folder / "CMakeCache.txt").exists() else ["-DBUILD_TESTING=OFF"]))
    run("cmake", "--build", "--preset", "release", "--target", "patinate_python", *PROGRAMS, "demo_page", "patinate_manual")
    return folder


def version():
    return re.search(r"project\(patinate VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def wheel_files(installed, data):
    """(place in the wheel, file): the module at its top, everything else below the environment's folder."""
    for path in sorted(installed.rglob("*")):
        if path.is_file() and "doc" not in path.relative_to(installed).parts:  # Those are Debian's.
            inside = path.relative_to(installed)
            parts = inside.parts
            yield ("/".join(parts[3:]) if parts[2:3] == ("dist-packages",) else f"{data}/data/{inside}"), path


TAG = f"cp{sys.version_info.major}{sys.version_info.minor}"
TAG = f"{TAG}-{TAG}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def metadata():
    """Texts of the .dist-info folder."""
    return {"METADATA": f"Metadata-Version: 2.1\nName: patinate\nVersion: {version()}\nSummary: How materials age\nLicense: MIT\n"
                        f"Requires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*\nRequires-Dist: numpy\n",
            "WHEEL": f"Wheel-Version: 1.0\nGenerator: patinate\nRoot-Is-Purelib: false\nTag: {TAG}\n"}


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory) / f"patinate-{version()}.dist-info"
    folder.mkdir()
    for name, text in metadata().items():
        (folder / name).write_text(text)
    return folder.name


INFO, DATA = f"patinate-{version()}.dist-info", f"patinate-{version()}.data"
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")


def refuse_other_python(modules, folder):
    if not list(modules):
        raise SystemExit(f"patinate: the build in {folder} has no module for this Python ({SUFFIX}); use /usr/bin/python3")


def write_wheel(wheel_directory, files):
    """files: (place in the wheel, file). Gives the wheel's name."""
    name, record = f"patinate-{version()}-{TAG}.whl", ""
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for place, path in files:
            wheel.write(path, place)
            digest = base64.urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).rstrip(b"=").decode()
            record += f"{place},sha256={digest},{path.stat().st_size}\n"
        for place, text in {**metadata(), "RECORD": record + "".join(f"{INFO}/{file},,\n" for file in ("METADATA", "WHEEL", "RECORD"))}.items():
            wheel.writestr(f"{INFO}/{place}", text)
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    folder = built_folder()
    with tempfile.TemporaryDirectory() as stage:
        installed = pathlib.Path(stage) / "installed"
        for component in COMPONENTS:
            run("cmake", "--install", folder, "--component", component, "--prefix", installed, "--strip")
        refuse_other_python(installed.glob(f"lib/*/dist-packages/patinate/_native{SUFFIX}"), folder)
        return write_wheel(wheel_directory, wheel_files(installed, DATA))


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """The module and the command are those of the build folder: after a change, `cmake --build` renews them."""
    folder = built_folder().resolve()
    refuse_other_python((folder / "python/patinate").glob(f"_native{SUFFIX}"), folder)
    with tempfile.TemporaryDirectory() as stage:
        path, command = pathlib.Path(stage) / "patinate.pth", pathlib.Path(stage) / "patinate"
        path.write_text(f"{folder / 'python'}\n")
        command.write_text(f"#!/bin/sh\nexec {shlex.quote(str(folder / 'bin/patinate'))} \"$@\"\n")
        command.chmod(0o755)
        return write_wheel(wheel_directory, [(path.name, path), (f"{DATA}/scripts/patinate", command)])


def source_files():
    """Tracked files; of a tree without git, as an unpacked source distribution, all but what was built."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True) if (ROOT / ".git").exists() else None
    if listed and listed.returncode == 0:
        return sorted(name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file())
    return sorted(str(path.relative_to(ROOT)) for path in ROOT.rglob("*")
                  if path.is_file() and path.relative_to(ROOT).parts[0] not in ("build", "PKG-INFO") and "__pycache__" not in path.parts)


def build_sdist(sdist_directory, config_settings=None):
    """The same bytes for the same files."""
    folder = f"patinate-{version()}"
    with open(pathlib.Path(sdist_directory) / f"{folder}.tar.gz", "wb") as file, gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar:
        def add(name, data, mode):
            member = tarfile.TarInfo(f"{folder}/{name}")
            member.size, member.mode = len(data), mode
            tar.addfile(member, io.BytesIO(data))
        add("PKG-INFO", metadata()["METADATA"].encode(), 0o644)
        for name in source_files():
            add(name, (ROOT / name).read_bytes(), 0o755 if os.access(ROOT / name, os.X_OK) else 0o644)
    return f"{folder}.tar.gz"
