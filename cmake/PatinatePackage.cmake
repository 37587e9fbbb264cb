# Debian packages of what is installed (tools/package): patinate, and beside it what most runs need (media), some need (markers, pcl), the Python
# module, the libraries for C++ and the manual.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME patinate)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_CONTACT "The patinate authors <patinate@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_NAME} built using CMake")  # The one that CPack does not put before those of components.
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENTS_ALL "")

execute_process(COMMAND gzip -9 -n -c "${PROJECT_SOURCE_DIR}/tools/packaging/changelog" OUTPUT_FILE "${PROJECT_BINARY_DIR}/changelog.gz" COMMAND_ERROR_IS_FATAL ANY)

# patinate_package(COMPONENT NAME SECTION TEXT [DEPENDS|RECOMMENDS|SUGGESTS package, ...]): what the component installs, as a package.
# TEXT: its first line, and behind it the others.
function(patinate_package component name section text)
  cmake_parse_arguments(PARSE_ARGV 4 arg "" "DEPENDS;RECOMMENDS;SUGGESTS" "")
  install(FILES tools/packaging/copyright "${PROJECT_BINARY_DIR}/changelog.gz" DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${name}" COMPONENT ${component})
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_FILE_NAME DEB-DEFAULT PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${key}_DESCRIPTION "${text}" PARENT_SCOPE)
  foreach(relation DEPENDS RECOMMENDS SUGGESTS)
    set(CPACK_DEBIAN_${key}_PACKAGE_${relation} "${arg_${relation}}" PARENT_SCOPE)
  endforeach()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

set(patinate_same_version "patinate (= ${PROJECT_VERSION})")
patinate_package(runtime patinate graphics "Capture, transfer and compare how materials age
Time-lapse photographs of a material that ages become a history, with which
meshes are aged according to a parameter of their surface."
  RECOMMENDS "patinate-library, patinate-media, python3-patinate" SUGGESTS "patinate-markers, patinate-pcl, patinate-doc")
patinate_package(library patinate-library graphics "Material histories to start from
Twelve synthetic materials that age, of 1024 pixels: rust, patina, cracks,
moss, soot, dust, frost and others. See patinate history library."
  RECOMMENDS patinate)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS OFF)
patinate_package(media patinate-media graphics "JPEG, TIFF, HDR, raw photographs and movies for patinate
PNG and EXR are read and written without it." DEPENDS "${patinate_same_version}")
patinate_package(markers patinate-markers graphics "Printed markers for patinate
Finds ArUco and AprilTag markers in photographs (ingest --align markers)." DEPENDS "${patinate_same_version}")
patinate_package(pcl patinate-pcl graphics "PCL's registration methods for patinate
They are there for comparison with patinate's own." DEPENDS "${patinate_same_version}")
if(TARGET patinate_python)
  math(EXPR patinate_next_python "${Python_VERSION_MINOR} + 1")  # A compiled module is for one version of Python.
  patinate_package(python python3-patinate python "How materials age, in Python
Histories of photographs, transfers to meshes, simulation and comparison
on numpy arrays. The command study is written in it."
    DEPENDS "${patinate_same_version}, python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${patinate_next_python}), python3-numpy"
    RECOMMENDS patinate-media SUGGESTS "python3-tqdm, python3-matplotlib")
endif()
patinate_package(development libpatinate-dev libdevel "Libraries and headers of patinate for C++
find_package(patinate COMPONENTS transfer simulation) and others."
  DEPENDS "nlohmann-json3-dev, libtbb-dev, libxxhash-dev, libeigen3-dev, libopenexr-dev, libpng-dev, zlib1g-dev, liblcms2-dev, libjpeg-dev, libembree-dev, libopenmesh-dev, libflann-dev, liblz4-dev, libtinygltf-dev, libmeshoptimizer-dev"
  RECOMMENDS "libceres-dev, libopencv-core-dev, libopencv-imgproc-dev, libopencv-features2d-dev, libopencv-calib3d-dev"
  SUGGESTS "libopenimageio-dev, libavformat-dev, libavcodec-dev, libswscale-dev, patinate-doc")
patinate_package(doc patinate-doc doc "Manual of patinate
Guides, reference pages, examples in C++, notebooks and schemas.")
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_PACKAGE_SHLIBDEPS OFF)
include(CPack)
