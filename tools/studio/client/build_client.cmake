# cmake -Dnpm=NPM -Dnode=NODE -Dbuilt=FOLDER -P build_client.cmake: node_modules as package-lock.json says, then the bundle.
# Several build folders share node_modules: one of them at a time.
set(here "${CMAKE_CURRENT_LIST_DIR}")
file(LOCK "${here}/.build.lock" GUARD PROCESS)

# Nothing is fetched, and no network needed, while the lock file is the one that was installed.
file(SHA256 "${here}/package-lock.json" wanted)
set(installed "")
set(mark "${here}/node_modules/.patinate_lock_file")
if(EXISTS "${mark}")
  file(READ "${mark}" installed)
endif()
if(NOT installed STREQUAL wanted)
  execute_process(COMMAND "${npm}" ci --ignore-scripts --prefer-offline --no-audit --no-fund --silent
    WORKING_DIRECTORY "${here}" RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(failed)
    message("${said}")
    message(FATAL_ERROR "npm could not install what the studio's client is made of (three.js, esbuild). "
      "It needs its registry once; `cmake -DPATINATE_STUDIO_CLIENT=OFF` builds all the rest without.")
  endif()
  file(WRITE "${mark}" "${wanted}")
endif()

execute_process(COMMAND "${node}" "${here}/build.mjs" "${built}" RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "the studio's client could not be bundled")
endif()
