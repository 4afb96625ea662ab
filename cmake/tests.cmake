# One test program per room, plus the shared oracles (libmicro/testing) they may all use.
find_package(GTest REQUIRED)
find_package(Boost REQUIRED)  # headers only: Boost.Math and Boost.Multiprecision serve as independent references
include(GoogleTest)

file(GLOB testing_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/libmicro/testing/*.cpp)
list(FILTER testing_sources EXCLUDE REGEX "_test\\.cpp$")
if(testing_sources)
  add_library(micro_testing STATIC ${testing_sources})
  target_link_libraries(micro_testing PUBLIC micro GTest::gtest Boost::headers PRIVATE micro_flags micro_warnings)
else()
  add_library(micro_testing INTERFACE)
  target_link_libraries(micro_testing INTERFACE micro GTest::gtest Boost::headers)
endif()

# add_room_tests(NAME FOLDER [LIBRARIES...]): builds FOLDER/*_test.cpp into one program and registers its tests.
function(add_room_tests name folder)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(${name}_test ${sources})
  target_link_libraries(${name}_test PRIVATE micro_testing micro_flags micro_warnings GTest::gtest_main ${ARGN})
  target_compile_definitions(
    ${name}_test
    PRIVATE MICRO_SOURCE_DIR="${PROJECT_SOURCE_DIR}" MICRO_SCANS_DIR="${PROJECT_SOURCE_DIR}/../shared/scans"
            MICROBRDF_PROGRAM="$<TARGET_FILE:microbrdf>")
  add_dependencies(${name}_test microbrdf)
  gtest_discover_tests(${name}_test DISCOVERY_MODE PRE_TEST PROPERTIES LABELS ${name} TIMEOUT 600)
endfunction()

foreach(room core height distribution ndf kirchhoff fit texture brdf testing)
  add_room_tests(${room} libmicro/${room})
endforeach()
add_room_tests(io libmicro/io hdf5::hdf5)
add_room_tests(pipelines pipelines micro_pipelines nlohmann_json::nlohmann_json hdf5::hdf5)
# Hostile files that go through the whole program, for each format.
target_compile_definitions(io_test PRIVATE MICRO_MUTATIONS_OF_PROGRAM=$<IF:$<BOOL:${MICRO_HEAVY}>,1000,10>)
# Random lobes in noise that are fitted.
target_compile_definitions(fit_test PRIVATE MICRO_NOISY_LOBES=$<IF:$<BOOL:${MICRO_HEAVY}>,1000,200>)
target_link_libraries(io_test PRIVATE OpenEXR::OpenEXR PNG::PNG ZLIB::ZLIB)
add_room_tests(tools tools micro_tools nlohmann_json::nlohmann_json hdf5::hdf5)
