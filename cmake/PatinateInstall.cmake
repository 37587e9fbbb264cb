# cmake --install: the binary, the libraries with their headers, and the package that find_package(patinate) reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(patinate_modules GLOBAL PROPERTY PATINATE_MODULES)
set(patinate_module_packages media markers pcl)
set(patinate_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/patinate")

foreach(component ${patinate_components})
  set_target_properties(patinate_${component} PROPERTIES EXPORT_NAME ${component})
  add_library(patinate::${component} ALIAS patinate_${component})
  install(TARGETS patinate_${component} EXPORT patinate-${component}
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
    FILE_SET HEADERS DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development)
  install(EXPORT patinate-${component} NAMESPACE patinate:: DESTINATION "${patinate_package_dir}" COMPONENT development)
endforeach()
install(TARGETS patinate RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT runtime)
install(TARGETS patinate-decode RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT media)
# A module whose libraries bring a hundred packages is a package of its own.
foreach(module ${patinate_modules})
  string(REPLACE "patinate-" "" component ${module})
  if(NOT component IN_LIST patinate_module_packages)
    set(component runtime)
  endif()
  install(TARGETS ${module} LIBRARY DESTINATION "${PATINATE_MODULES_DIR}" COMPONENT ${component})
endforeach()
# The demo, for those who have no copy of the repository.
install(TARGETS demo_page RUNTIME DESTINATION "${PATINATE_MODULES_DIR}" COMPONENT runtime)
# What tools/library/build has made, if it was run; and Blender's add-on.
install(DIRECTORY "${PROJECT_BINARY_DIR}/share/patinate/library" DESTINATION "${CMAKE_INSTALL_DATADIR}/patinate" COMPONENT library OPTIONAL)
install(FILES tools/blender/patinate_blender.py DESTINATION "${CMAKE_INSTALL_DATADIR}/patinate/blender" COMPONENT runtime)
install(PROGRAMS tools/demo DESTINATION "${CMAKE_INSTALL_DATADIR}/patinate" COMPONENT runtime)

# The manual and the completions are what the binary says of itself.
if(NOT PATINATE_SANITIZE)
  set(patinate_said "${PROJECT_BINARY_DIR}/said")
  file(MAKE_DIRECTORY "${patinate_said}")
  add_custom_command(OUTPUT "${patinate_said}/patinate.1.gz"
    COMMAND patinate help --man > "${patinate_said}/patinate.1"
    COMMAND gzip -9 -n -f "${patinate_said}/patinate.1"
    COMMAND patinate help completion bash > "${patinate_said}/patinate"
    COMMAND patinate help completion zsh > "${patinate_said}/_patinate"
    COMMAND patinate help completion fish > "${patinate_said}/patinate.fish"
    DEPENDS patinate VERBATIM)
  add_custom_target(patinate_manual ALL DEPENDS "${patinate_said}/patinate.1.gz")
  install(FILES "${patinate_said}/patinate.1.gz" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT runtime)
  install(FILES "${patinate_said}/patinate" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT runtime)
  install(FILES "${patinate_said}/_patinate" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions" COMPONENT runtime)
  install(FILES "${patinate_said}/patinate.fish" DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d" COMPONENT runtime)
endif()

configure_package_config_file(cmake/patinate-config.cmake.in "${PROJECT_BINARY_DIR}/patinate-config.cmake"
  INSTALL_DESTINATION "${patinate_package_dir}" PATH_VARS PATINATE_MODULES_DIR)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/patinate-config-version.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/patinate-config.cmake" "${PROJECT_BINARY_DIR}/patinate-config-version.cmake"
  cmake/PatinateComponents.cmake cmake/PatinateDependencies.cmake DESTINATION "${patinate_package_dir}" COMPONENT development)
install(FILES LICENSE README.md CITATION.cff DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT runtime)
install(DIRECTORY docs/ DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/patinate-doc" COMPONENT doc PATTERN CMakeLists.txt EXCLUDE)
include(PatinatePkgConfig)
include(PatinatePackage)
