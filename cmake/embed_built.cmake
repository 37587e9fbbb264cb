# cmake -Dembedded_namespace=NAMESPACE -Dsymbol=NAME -Dfile=FILE -Dsource=CPP -P embed_built.cmake: what patinate_embed_built() runs.
file(READ "${file}" text)
configure_file("${CMAKE_CURRENT_LIST_DIR}/embedded.cpp.in" "${source}" @ONLY)
