# Every library that our libraries stand on, found once, here and by users of the installed package; what only modules need is in PatinateModules.cmake.
# tools/setup installs them.

# OpenCV's own CMake package comes only with Debian's libopencv-dev, which brings every module (and VTK, Qt, GDAL) along;
# the modules that we use are found one by one instead.
function(patinate_find_opencv)
  find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
  foreach(module ${ARGN})
    find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
    add_library(opencv_${module} UNKNOWN IMPORTED GLOBAL)
    set_target_properties(opencv_${module} PROPERTIES
      IMPORTED_LOCATION "${OPENCV_${module}_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${OPENCV_INCLUDE_DIR}")
  endforeach()
endfunction()

find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(OpenEXR 3.1 REQUIRED)
find_package(PNG 1.6 REQUIRED)
find_package(ZLIB REQUIRED)
patinate_find_opencv(core imgproc features2d calib3d)
find_package(OpenMesh REQUIRED)
find_package(Ceres 2.1 REQUIRED)
find_package(embree 3.13 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(TinyGLTF REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(FLANN REQUIRED IMPORTED_TARGET flann)
