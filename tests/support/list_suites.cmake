# cmake -Dname=NAME -Dprogram=FILE -Dtimeout=SECONDS -Dfile=FILE -P list_suites.cmake: writes a ctest entry for each suite of a GoogleTest program.
# Parametrized and typed suites are one entry each, whatever their instances are called.
execute_process(COMMAND "${program}" --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" lines "${listed}")
foreach(line ${lines})
  if(line MATCHES "^([A-Za-z0-9_]+/)?([A-Za-z_][A-Za-z0-9_]*)(/[0-9]+)?\\.")  # Cases are indented.
    list(APPEND suites "${CMAKE_MATCH_2}")
  endif()
endforeach()
list(REMOVE_DUPLICATES suites)
set(text "")
foreach(suite ${suites})
  string(APPEND text "add_test(${suite} \"${program}\" --gtest_filter=${suite}.*:*/${suite}.*:${suite}/*:*/${suite}/*)\n"
    "set_tests_properties(${suite} PROPERTIES TIMEOUT ${timeout} LABELS ${name})\n")
endforeach()
file(WRITE "${file}" "${text}")
