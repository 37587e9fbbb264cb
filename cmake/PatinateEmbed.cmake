set(patinate_embed_template "${CMAKE_CURRENT_LIST_DIR}/embedded.cpp.in")

# patinate_embed(TARGET NAMESPACE SYMBOL FILE): the text of FILE as `extern const std::string_view SYMBOL` of NAMESPACE, so that an installed
# program looks for no file. Declare it in a header of the target.
function(patinate_embed target embedded_namespace symbol file)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  file(READ "${file}" text)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/embedded_${symbol}.cpp")
  configure_file("${patinate_embed_template}" "${source}" @ONLY)
  set_source_files_properties("${source}" PROPERTIES UNITY_GROUP embedded)
  target_sources(${target} PRIVATE "${source}")
endfunction()

# patinate_embed_built(TARGET NAMESPACE SYMBOL FILE): the same for a FILE that the build makes.
set(patinate_embed_script "${CMAKE_CURRENT_LIST_DIR}/embed_built.cmake")
function(patinate_embed_built target embedded_namespace symbol file)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/embedded_${symbol}.cpp")
  add_custom_command(OUTPUT "${source}"
    COMMAND "${CMAKE_COMMAND}" -Dembedded_namespace=${embedded_namespace} -Dsymbol=${symbol} "-Dfile=${file}" "-Dsource=${source}" -P "${patinate_embed_script}"
    DEPENDS "${file}" "${patinate_embed_script}" "${patinate_embed_template}"
    COMMENT "Embedding ${symbol}" VERBATIM)
  set_source_files_properties("${source}" PROPERTIES UNITY_GROUP embedded)
  target_sources(${target} PRIVATE "${source}")
endfunction()
