# Parts that programs load when they need them (libcommon/core/module.h), because the libraries below them cost every start a third of a second.
include(GNUInstallDirs)
# Where modules are installed, and how programs of the same prefix get there.
set(PATINATE_MODULES_DIR "${CMAKE_INSTALL_LIBDIR}/patinate")
file(RELATIVE_PATH PATINATE_MODULES_FROM_PROGRAMS "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}/patinate")
# The same of the library of histories, which tools/library/build puts beside what is built.
file(RELATIVE_PATH PATINATE_LIBRARY_FROM_PROGRAMS "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_DATADIR}/patinate/library")
# Debian's Python looks into /usr/lib/python3/dist-packages, and for what is installed locally into /usr/local/lib/python3.11/dist-packages.
set(patinate_python_folder_name python3)
if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr" AND Python_VERSION_MINOR)
  set(patinate_python_folder_name "python3.${Python_VERSION_MINOR}")
endif()
set(PATINATE_PYTHON_DIR "lib/${patinate_python_folder_name}/dist-packages" CACHE STRING "Where the Python package is installed, below the prefix")
file(RELATIVE_PATH PATINATE_PYTHON_FROM_PROGRAMS "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_PREFIX}/${PATINATE_PYTHON_DIR}")

# patinate_module(NAME SOURCES a.cpp ... PRIVATE deps): NAME.so, built beside the programs. It uses our headers, but links none of our libraries:
# what these keep would be there twice. It shows nothing but what it marks as visible.
function(patinate_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PRIVATE")
  add_library(${name} MODULE ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES
    PREFIX "" SUFFIX ".so" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON LIBRARY_OUTPUT_DIRECTORY "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/libcommon/include" "${PROJECT_SOURCE_DIR}/capture/include")
  target_link_libraries(${name} PRIVATE patinate_flags ${arg_PRIVATE})
  if(NOT PATINATE_SANITIZE)  # Sanitizers' own functions come with the program.
    target_link_options(${name} PRIVATE LINKER:-z,defs)
  endif()
  set_property(GLOBAL APPEND PROPERTY PATINATE_MODULES ${name})
endfunction()
