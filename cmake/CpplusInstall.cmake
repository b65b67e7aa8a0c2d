# What `cmake --install` puts into a prefix: the program, the libraries with their headers, and the package that
# find_package(cpplus) finds there (docs/library.md).
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cpplus)
install(TARGETS cpplus)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/src/cpplus DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h" PATTERN "test_*.h" EXCLUDE)

# Static libraries name it as a thing to link with; its warnings stay here.
set_target_properties(cpplus_build_flags PROPERTIES EXPORT_NAME build_flags)
install(TARGETS cpplus_build_flags EXPORT cpplusTargets)
install(EXPORT cpplusTargets NAMESPACE cpplus:: DESTINATION ${package_dir})

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/cpplusConfig.cmake.in ${CMAKE_BINARY_DIR}/cpplusConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/cpplusConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/cpplusConfig.cmake ${CMAKE_BINARY_DIR}/cpplusConfigVersion.cmake
        DESTINATION ${package_dir})
