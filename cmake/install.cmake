# The program, and the library as a CMake package: find_package(microbrdf), target microbrdf::micro.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/microbrdf)

install(TARGETS microbrdf RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS micro EXPORT microbrdf_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY libmicro/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/microbrdf
        FILES_MATCHING PATTERN "*.h" PATTERN testing EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(EXPORT microbrdf_targets FILE microbrdf-targets.cmake NAMESPACE microbrdf:: DESTINATION ${package_dir})

configure_package_config_file(cmake/microbrdf-config.cmake.in ${PROJECT_BINARY_DIR}/microbrdf-config.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/microbrdf-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/microbrdf-config.cmake ${PROJECT_BINARY_DIR}/microbrdf-config-version.cmake
        DESTINATION ${package_dir})
