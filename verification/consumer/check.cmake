# Installs the build in BUILD_DIR to a staging folder, builds the consumer in CONSUMER_DIR against it and checks what it
# prints. Other arguments: GENERATOR, CXX_COMPILER.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nfailed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(work ${BUILD_DIR}/consumer)
file(REMOVE_RECURSE ${work})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --component development --prefix ${work}/installed)
file(RENAME ${work}/installed ${work}/moved)  # the package must not remember where it was installed

run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CONSUMER_DIR} -B ${work}/build -DCMAKE_PREFIX_PATH=${work}/moved
  -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/consumer)
message("${output}")

# One of 64 cells became eight; its three faces inside the body bring three centres and nine edges that hang.
if(NOT output MATCHES "71 cells, 12 of 144 nodes hang")
  message(FATAL_ERROR "not the mesh that the consumer asked for")
endif()
# t² V / E = 0.1 J if the sides were free all the way down, t² V / (lambda + 2 mu) = 0.0743 J if all of them were held;
# the clamped cube lies between, and so does its approximation, whose space holds the second field.
string(REGEX MATCH "converged 1, energy ([0-9.e+-]+) J" line "${output}")
if(NOT line OR NOT CMAKE_MATCH_1 GREATER 0.0743 OR NOT CMAKE_MATCH_1 LESS 0.1)
  message(FATAL_ERROR "energy out of its bounds [0.0743, 0.1] J")
endif()

# A tetrahedron with a vertex that it does not use.
file(WRITE ${work}/tetrahedron.obj "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
run(${work}/build/surface_consumer ${work}/tetrahedron.obj)
if(NOT output MATCHES "4 triangles, 1 notes")
  message(FATAL_ERROR "not the surface that the consumer read: ${output}")
endif()
