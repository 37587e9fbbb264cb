#!/usr/bin/env python3
"""Asks an installed patinate for each component alone. Usage: components_test.py SOURCE PREFIX WORK_FOLDER"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

SOURCE, PREFIX, WORK = (pathlib.Path(p).resolve() for p in sys.argv[1:4])
del sys.argv[1:]
# A header of each component.
HEADERS = {
    "core": "core/error.h", "image": "image/image_io.h", "geometry": "geometry/mesh.h", "mesh_files": "mesh_files/mesh_io.h", "media": "output/movie.h",
    "atlas": "atlas/unwrap.h", "metrics": "metrics/difference.h", "history": "history/memory_history.h", "controls": "controls/control_map.h",
    "device": "core/error.h", "job": "core/run_control.h", "output": "output/render.h", "calibration": "capture/camera_calibration.h", "registration": "capture/registration.h",
    "capture": "capture/make_history.h", "transfer": "transfer/transfer.h", "simulation": "simulation/engine.h", "analysis": "analysis/comparison.h",
    "datasets": "datasets/crackle.h",
}
PER_COMMIT = ["core", "transfer", "simulation"]
HEAVY = re.compile(r"pcl|libav|ffmpeg", re.IGNORECASE)
NEED_HEAVY = {"registration", "capture", "media"}


def components():
    text = (SOURCE / "cmake/PatinateComponents.cmake").read_text()
    return re.search(r"set\(patinate_components\s+([^)]*)\)", text).group(1).split()


def configure(component, header):
    folder = WORK / f"component_{component}"
    said = subprocess.run(
        ["cmake", "-S", SOURCE / "tests/install/component", "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={PREFIX}", f"-DCOMPONENT={component}",
         f"-DHEADER=patinate/{header}", f"-DCMAKE_CXX_COMPILER_LAUNCHER={shutil.which('ccache') or ''}"],
        capture_output=True, text=True)
    return folder, said


class Components(unittest.TestCase):
    def test_each_is_found_alone_and_compiles(self):
        self.assertGreater(len(components()), 10)
        self.assertEqual(sorted(HEADERS), sorted(components()))
        for component in components() if os.environ.get("PATINATE_NIGHTLY") else PER_COMMIT:
            with self.subTest(component=component):
                folder, said = configure(component, HEADERS[component])
                self.assertEqual(said.returncode, 0, said.stderr)
                built = subprocess.run(["cmake", "--build", folder], capture_output=True, text=True)
                self.assertEqual(built.returncode, 0, built.stdout)
                if component not in NEED_HEAVY:
                    looked_for = [line for line in (folder / "CMakeCache.txt").read_text().splitlines() if HEAVY.search(line)]
                    self.assertEqual(looked_for, [])

    def test_one_that_does_not_exist_is_named(self):
        _, said = configure("simulations", "core/error.h")
        self.assertNotEqual(said.returncode, 0)
        self.assertIn("patinate has no component simulations", " ".join(said.stderr.split()))

    def test_an_optional_one_that_does_not_exist_is_not_found_and_no_error(self):
        folder = WORK / "optional"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text("""cmake_minimum_required(VERSION 3.25)
project(optional CXX)
find_package(patinate REQUIRED COMPONENTS core OPTIONAL_COMPONENTS nope)
if(NOT patinate_FOUND OR NOT patinate_core_FOUND OR patinate_nope_FOUND OR NOT TARGET patinate::core)
  message(FATAL_ERROR "wrong: ${patinate_FOUND} ${patinate_core_FOUND} ${patinate_nope_FOUND}")
endif()
""")
        said = subprocess.run(["cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={PREFIX}"], capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)

    def test_pkg_config_says_all_that_a_program_needs(self):
        (WORK / "use.cpp").write_text("""#include <patinate/patinate.h>
#include <patinate/history/memory_history.h>
#include <patinate/image/image_io.h>
#include <cstdio>
int main() {
  using namespace patinate;
  MemoryHistoryImages images{.name = "x", .frames = {{.time = 0.0, .color = ImageF(8, 8, 3, 0.5f)}}};
  const MemoryHistory history(images);
  write_color("use.jpg", history.read_frame(0));  // By a module, which is loaded from where it was installed.
  std::printf("%d %d\\n", read_color("use.jpg").width(), history.num_frames());
}
""")
        place, = PREFIX.glob("lib*/**/pkgconfig")
        environment = {**os.environ, "PKG_CONFIG_PATH": str(place)}

        def said_by(*command):
            result = subprocess.run(command, cwd=WORK, env=environment, capture_output=True, text=True)
            self.assertEqual(result.returncode, 0, result.stderr)
            return result.stdout
        flags = said_by("pkg-config", "--cflags", "--libs", "patinate").split()
        compiler = [shutil.which("ccache")] if shutil.which("ccache") else []
        split = flags.index(next(flag for flag in flags if flag.startswith("-L")))
        said_by(*compiler, "g++", "-c", "use.cpp", *flags[:split])
        said_by("g++", "use.o", *flags[split:], "-o", "use")
        self.assertEqual(said_by("./use"), "8 1\n")
        self.assertIn(said_by("pkg-config", "--modversion", "patinate").strip(), (SOURCE / "CMakeLists.txt").read_text())

    def test_internal_headers_are_not_installed(self):
        installed = {str(p.relative_to(PREFIX / "include")) for p in (PREFIX / "include").rglob("*.h")}
        public = {str(p).rsplit("/include/", 1)[1] for p in SOURCE.glob("*/include/**/*.h")}
        self.assertEqual(installed, public)
        self.assertGreater(len(installed), 50)


if __name__ == "__main__":
    unittest.main()
