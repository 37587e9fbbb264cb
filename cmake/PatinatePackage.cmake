# Debian packages of what is installed (tools/package): patinate, and python3-patinate beside it.
install(FILES tools/packaging/copyright DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/patinate" COMPONENT runtime)
install(FILES tools/packaging/copyright DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/python3-patinate" COMPONENT python)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME patinate)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_CONTACT "The patinate authors <patinate@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime)
if(TARGET patinate_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS "${PROJECT_SOURCE_DIR}/cmake/compress_manual.cmake")

set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME patinate)
set(CPACK_DEBIAN_RUNTIME_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS python3-patinate)  # `patinate study` is written in it.
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Capture, transfer and compare how materials age
 Time-lapse photographs of a material that ages become a history, with which
 meshes are aged according to a parameter of their surface.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-patinate)
set(CPACK_DEBIAN_PYTHON_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
# A compiled module is for one version of Python.
math(EXPR patinate_next_python "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "patinate (= ${PROJECT_VERSION}), python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${patinate_next_python}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-tqdm, python3-matplotlib")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "How materials age, in Python
 Histories of photographs, transfers to meshes, simulation and comparison
 on numpy arrays.")
include(CPack)
