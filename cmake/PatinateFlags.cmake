# One INTERFACE target carries our compiler flags; every target of ours links it PRIVATE.
option(PATINATE_WARNINGS_AS_ERRORS "Stop at the first warning (the presets and CI set this)" OFF)
set(PATINATE_SANITIZE "" CACHE STRING "Sanitizers for every target, e.g. address,undefined")
option(PATINATE_FUZZ "Build the libFuzzer targets of tests/fuzz (clang; the preset fuzz sets this)" OFF)

# The Python module is a shared library, so that all of ours that it links must be position-independent.
if(NOT PATINATE_SANITIZE)  # An interpreter is not sanitized.
  find_program(PATINATE_PYTHON_PROGRAM NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "Python that the module is made for: Debian's, as pybind11 is")
  set(Python_EXECUTABLE "${PATINATE_PYTHON_PROGRAM}")
  find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module NumPy)
  set(PYBIND11_FINDPYTHON ON)
  find_package(pybind11 2.10 QUIET CONFIG)
endif()
set(PATINATE_PYTHON_IS_FOUND OFF)
if(pybind11_FOUND AND Python_Development.Module_FOUND)
  set(PATINATE_PYTHON_IS_FOUND ON)
endif()
option(PATINATE_PYTHON "Build the Python module (python/)" ${PATINATE_PYTHON_IS_FOUND})

add_library(patinate_flags INTERFACE)
target_compile_features(patinate_flags INTERFACE cxx_std_20)
# -ffp-contract=off: no fused multiply-add, so equal input gives equal bits for every instruction set.
target_compile_options(patinate_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wnon-virtual-dtor -ffp-contract=off
  $<$<CXX_COMPILER_ID:Clang>:-Wno-sign-conversion>  # As g++ has it: an index is an int that its loop bounds.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 warns about every "text" + std::string [GCC bug 105651]
  $<$<BOOL:${PATINATE_WARNINGS_AS_ERRORS}>:-Werror>)
if(PATINATE_SANITIZE)
  target_compile_options(patinate_flags INTERFACE -fsanitize=${PATINATE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(patinate_flags INTERFACE -fsanitize=${PATINATE_SANITIZE})
endif()

find_program(MOLD_PROGRAM mold)  # Links in a fifth of the time.
if(MOLD_PROGRAM AND NOT PATINATE_SANITIZE AND NOT CMAKE_INTERPROCEDURAL_OPTIMIZATION)
  target_link_options(patinate_flags INTERFACE -fuse-ld=mold)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # Paths count from the repository root, so that one clone finds what another has compiled, wherever they lie.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_NOHASHDIR=1 "${CCACHE_PROGRAM}")
endif()

# patinate_unity(TARGET [NAME]): with PATINATE_UNITY, several sources of a folder are compiled as one, because most of a compile is reading headers; with
# NAME, which names the batches, all folders of the target together. Batches of a folder are of about one size and hold at most PATINATE_UNITY_BYTES of source: a compile then needs less than 1.2 GB. Sources with flags of their own
# are compiled alone, and those that patinate_alone() names.
option(PATINATE_UNITY "Compile several sources of a folder as one (presets that look for missing includes do not)" ON)
set(PATINATE_UNITY_BYTES 100000 CACHE STRING "How much of a folder's source is compiled as one, in bytes")
mark_as_advanced(PATINATE_UNITY_BYTES)
#
# patinate_fast(FOLDER ...), called before: folders (by their last name) of the targets made here whose loops run over pixels, texels, triangles or
# particles. All others are compiled with -O1, in two thirds of the time.
macro(patinate_fast)
  set(patinate_fast_folders ${ARGN})
endmacro()
function(patinate_unity target)
  if(NOT PATINATE_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # What g++ says wrongly of several sources at once: that a type of an unnamed namespace is in a header, and sizes that it guesses once it has
  # inlined more. The presets that compile source by source ask for both.
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-maybe-uninitialized>)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  foreach(source ${sources})
    get_source_file_property(is_alone "${source}" SKIP_UNITY_BUILD_INCLUSION)
    if(is_alone)
      list(REMOVE_ITEM sources "${source}")
      continue()
    endif()
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE file)
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET folder FILENAME name)
    if(ARGC GREATER 1)
      set(name "${ARGV1}")
    endif()
    file(SIZE "${file}" bytes)
    set(folder_of_${source} ${name})
    set(begin_of_${source} "${held_${name}}")
    math(EXPR held_${name} "0${held_${name}} + ${bytes}")
  endforeach()
  foreach(source ${sources})  # Batches of a folder are of about the same size.
    set(name ${folder_of_${source}})
    math(EXPR batches "(${held_${name}} + ${PATINATE_UNITY_BYTES} - 1) / ${PATINATE_UNITY_BYTES}")
    math(EXPR batch "0${begin_of_${source}} * ${batches} / ${held_${name}}")
    set_source_files_properties("${source}" PROPERTIES UNITY_GROUP ${name}_${batch})
    if(NOT name IN_LIST patinate_fast_folders)
      set_source_files_properties("${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/Unity/unity_${name}_${batch}_cxx.cxx" PROPERTIES
        COMPILE_OPTIONS "$<$<CONFIG:Release>:-O1>")
    endif()
  endforeach()
endfunction()

# patinate_alone(a.cpp ...): sources of this folder that are never compiled with others, called before their target is made: kernels that are compiled
# once an instruction set, and what includes headers that are heavy in themselves (PCL, Ceres, Beast, OpenMesh).
function(patinate_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# patinate_alone_headers(RESULT "a.h;b.h" "a.cpp;c.cpp"): the headers that are not the first include of the source of their name.
function(patinate_alone_headers result headers sources)
  foreach(header ${headers})
    string(REGEX REPLACE "\\.h$" ".cpp" source "${header}")
    set(first "")
    if(source IN_LIST sources)
      file(STRINGS "${source}" first REGEX "^#include" LIMIT_COUNT 1)
    endif()
    if(NOT first MATCHES "/${header}\"$")
      list(APPEND alone "${header}")
    endif()
  endforeach()
  set(${result} "${alone}" PARENT_SCOPE)
endfunction()

# patinate_library(NAME SOURCES a.cpp ... HEADERS include/patinate/x/a.h ... x/b.h ... PUBLIC deps PRIVATE deps)
# Headers below include/ are public: installed, and included as "patinate/x/a.h" everywhere. The others are found from the repository root
# ("libcommon/image/b.h") while we build, and not installed. The target all_verify_interface_header_sets compiles every public header alone,
# and every other that no source of its name includes first: that source shows as much.
function(patinate_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE")
  set(public_headers ${arg_HEADERS})
  list(FILTER public_headers INCLUDE REGEX "^include/")
  set(internal_headers ${arg_HEADERS})
  list(FILTER internal_headers EXCLUDE REGEX "^include/")
  add_library(${name} STATIC ${arg_SOURCES})
  target_sources(${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${public_headers})
  target_include_directories(${name} PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>")
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  if(PATINATE_PYTHON)
    # Hidden: a library that shows nothing calls its own functions as directly as a program does.
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  endif()
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PUBLIC ${arg_PUBLIC} PRIVATE $<BUILD_INTERFACE:patinate_flags> ${arg_PRIVATE})
  if(internal_headers)
    # A target of their own, so that the exported one does not offer them.
    add_library(${name}_internal INTERFACE)
    patinate_alone_headers(alone "${internal_headers}" "${arg_SOURCES}")
    list(REMOVE_ITEM internal_headers ${alone})
    target_sources(${name}_internal INTERFACE
      FILE_SET alone TYPE HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}" FILES ${alone}
      FILE_SET included_first TYPE HEADERS BASE_DIRS "${PROJECT_SOURCE_DIR}" FILES ${internal_headers})
    if(alone)
      set_target_properties(${name}_internal PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON INTERFACE_HEADER_SETS_TO_VERIFY alone)
    endif()
    target_link_libraries(${name}_internal INTERFACE ${name})
  endif()
  patinate_unity(${name})
endfunction()

# patinate_kernels(a b ...): a_baseline.cpp, a_avx2.cpp and a_avx512.cpp in this folder, which include one source, get the flags of
# their instruction set (libcommon/core/instruction_set.h chooses). Such sources hold no inline function of a header: the linker keeps
# one of all copies, whatever it was compiled for.
function(patinate_kernels)
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    return()
  endif()
  foreach(kernel ${ARGN})
    patinate_alone(${kernel}_baseline.cpp)
    set_source_files_properties(${kernel}_avx2.cpp PROPERTIES COMPILE_OPTIONS "-mavx2")
    set_source_files_properties(${kernel}_avx512.cpp PROPERTIES
      COMPILE_OPTIONS "-mavx512f;-mavx512bw;-mavx512dq;-mavx512vl;-mprefer-vector-width=512")
  endforeach()
endfunction()
