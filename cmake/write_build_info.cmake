# Writes the header of build information; run at every build, so that the commit is never that of an older configure.
# Arguments: VALUES (a script that sets the other values), INPUT, OUTPUT, SOURCE_DIR.
include(${VALUES})

set(FINEGAUGE_COMMIT "unknown")
find_program(GIT git)
if(GIT)
  execute_process(COMMAND ${GIT} rev-parse --short=12 HEAD WORKING_DIRECTORY ${SOURCE_DIR}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(FINEGAUGE_COMMIT "${commit}")
    # Of what a build is made and reads; scenes, the user's own too, are told by their SHA-256 in each result.
    execute_process(COMMAND ${GIT} status --porcelain -- CMakeLists.txt CMakePresets.json cmake core verification benchmarks
        reference_data ":(exclude)reference_data/scenes/*.toml"
      WORKING_DIRECTORY ${SOURCE_DIR} OUTPUT_VARIABLE changes ERROR_QUIET)
    if(changes)
      string(APPEND FINEGAUGE_COMMIT "-dirty")
    endif()
  endif()
endif()

configure_file(${INPUT} ${OUTPUT} @ONLY)  # leaves the file alone when nothing changed
