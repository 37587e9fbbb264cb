"""`pip install .` (PEP 517): CMake compiles, and a wheel takes the module and the programs that it starts. It needs no other package."""
import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
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


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name, folder, suffix = f"patinate-{version()}-{TAG}.whl", built_folder(), sysconfig.get_config_var("EXT_SUFFIX")
    record = ""
    with tempfile.TemporaryDirectory() as stage, zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        installed, info = pathlib.Path(stage) / "installed", f"patinate-{version()}.dist-info"
        for component in COMPONENTS:
            run("cmake", "--install", folder, "--component", component, "--prefix", installed, "--strip")
        if not list(installed.glob(f"lib/*/dist-packages/patinate/_native{suffix}")):
            raise SystemExit(f"patinate: the build in {folder} has no module for this Python ({suffix}); use /usr/bin/python3")
        for place, path in wheel_files(installed, info.replace("dist-info", "data")):
            wheel.write(path, place)
            digest = base64.urlsafe_b64encode(hashlib.sha256(path.read_bytes()).digest()).rstrip(b"=").decode()
            record += f"{place},sha256={digest},{path.stat().st_size}\n"
        for place, text in {**metadata(), "RECORD": record + "".join(f"{info}/{file},,\n" for file in ("METADATA", "WHEEL", "RECORD"))}.items():
            wheel.writestr(f"{info}/{place}", text)
    return name
