# Every library that our libraries stand on, found once, here and by users of the installed package. tools/setup installs them.

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
find_package(OpenImageIO 2.4 REQUIRED)
patinate_find_opencv(core imgproc features2d calib3d)
find_package(OpenMesh REQUIRED)
find_package(Ceres 2.1 REQUIRED)
find_package(embree 3.13 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(TinyGLTF REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(LIBAV REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil libswscale)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(FLANN REQUIRED IMPORTED_TARGET flann)

# PCL's own CMake package brings VTK along; its modules are found one by one instead.
function(patinate_find_pcl)
  find_path(PCL_INCLUDE_DIR pcl/point_types.h PATH_SUFFIXES pcl-1.13 pcl-1.14 pcl-1.15 REQUIRED)
  foreach(module ${ARGN})
    find_library(PCL_${module}_LIBRARY pcl_${module} REQUIRED)
    add_library(pcl_${module} UNKNOWN IMPORTED GLOBAL)
    set_target_properties(pcl_${module} PROPERTIES
      IMPORTED_LOCATION "${PCL_${module}_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${PCL_INCLUDE_DIR}"
      INTERFACE_LINK_LIBRARIES Eigen3::Eigen)
  endforeach()
endfunction()
patinate_find_pcl(common features filters kdtree registration search)
