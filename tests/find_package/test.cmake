# Installs the build into a folder of its own, builds the consumer against it and runs it.
# Wants BUILD_DIR, SOURCE_DIR, VERSION, CXX_COMPILER, CXX_FLAGS, GENERATOR.
set(prefix ${BUILD_DIR}/find_package/prefix)
set(consumer ${BUILD_DIR}/find_package/consumer)

function(step)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${prefix} ${consumer})
step(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

# A package that leans on the folder it was built in works only where it was built.
file(GLOB_RECURSE package_files ${prefix}/*.cmake)
foreach(file ${package_files})
  file(READ ${file} text)
  foreach(folder ${SOURCE_DIR} ${BUILD_DIR})
    string(FIND "${text}" "${folder}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} names ${folder}")
    endif()
  endforeach()
endforeach()

step(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${consumer} -G ${GENERATOR} -D CMAKE_PREFIX_PATH=${prefix}
     -D CMAKE_CXX_COMPILER=${CXX_COMPILER} -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D VERSION=${VERSION})
step(${CMAKE_COMMAND} --build ${consumer})
step(${consumer}/consumer)
step(${prefix}/bin/microbrdf --version)
