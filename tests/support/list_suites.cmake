# cmake -Dname=NAME -Dprogram=FILE -Dtimeout=SECONDS -Dnightly=SUITE,SUITE -Dfile=FILE -P list_suites.cmake: writes a ctest entry for each suite of a GoogleTest program.
# Parametrized and typed suites are one entry each, whatever their instances are called.
cmake_minimum_required(VERSION 3.25)  # IN_LIST
execute_process(COMMAND "${program}" --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" lines "${listed}")
foreach(line ${lines})
  if(line MATCHES "^([A-Za-z0-9_]+/)?([A-Za-z_][A-Za-z0-9_]*)(/[0-9]+)?\\.")  # Cases are indented.
    list(APPEND suites "${CMAKE_MATCH_2}")
  endif()
endforeach()
list(REMOVE_DUPLICATES suites)
string(REPLACE "," ";" nightly "${nightly}")
foreach(suite ${nightly})
  if(NOT suite IN_LIST suites)
    message(FATAL_ERROR "${name} has no suite ${suite}, which tests/CMakeLists.txt calls nightly")
  endif()
endforeach()
set(text "")
foreach(suite ${suites})
  set(labels ${name})
  if(suite IN_LIST nightly)
    list(APPEND labels nightly)
  endif()
  string(APPEND text "add_test(${suite} \"${program}\" --gtest_filter=${suite}.*:*/${suite}.*:${suite}/*:*/${suite}/*)\n"
    "set_tests_properties(${suite} PROPERTIES TIMEOUT ${timeout} LABELS \"${labels}\")\n")
endforeach()
file(WRITE "${file}" "${text}")
