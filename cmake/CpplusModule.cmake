# Warnings and sanitizers for every target of this project.
add_library(cpplus_build_flags INTERFACE)
target_compile_options(cpplus_build_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow
                       $<$<BOOL:${CPPLUS_WERROR}>:-Werror>)
# Nobody asks for errno after a root nor for floating-point exceptions: without them loops with roots and selections
# become vector instructions. No result differs.
target_compile_options(cpplus_build_flags INTERFACE -fno-math-errno -fno-trapping-math)
# What is computed must not depend on which vector instructions a processor has (core/vector_clones.h).
target_compile_options(cpplus_build_flags INTERFACE -ffp-contract=off)
# GCC 12 warns of overlapping copies in std::string where there are none (its bug 105329), in large files above all.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(cpplus_build_flags INTERFACE -Wno-restrict)
endif()
if(CPPLUS_SANITIZE)
  target_compile_options(cpplus_build_flags INTERFACE -fsanitize=${CPPLUS_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(cpplus_build_flags INTERFACE -fsanitize=${CPPLUS_SANITIZE})
endif()

# cpplus_unity(TARGET [file...])
#
# With CPPLUS_UNITY the target's files are compiled several at once. Files whose private names other files of the target
# have as well follow its name: they are compiled apart.
function(cpplus_unity target)
  if(CPPLUS_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# cpplus_module(NAME [DEPENDS module...] [LIBRARIES target...] [APART file...])
#
# One folder = one static library cpplus_NAME from its *.cpp, and one test program cpplus_NAME_test from
# its *_test.cpp. DEPENDS are the modules below it (public); LIBRARIES are third-party targets that only
# the .cpp files may include (private); APART are files that cpplus_unity() leaves apart. Tests whose suite name starts
# with "Slow" carry the label slow.
function(cpplus_module name)
  cmake_parse_arguments(arg "" "" "DEPENDS;LIBRARIES;TEST_LIBRARIES;APART" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")

  add_library(cpplus_${name} STATIC ${sources})
  cpplus_unity(cpplus_${name} ${arg_APART})
  set_target_properties(cpplus_${name} PROPERTIES LINKER_LANGUAGE CXX)
  target_include_directories(cpplus_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src>
                                                   $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(cpplus_${name} PUBLIC cxx_std_20)
  target_link_libraries(cpplus_${name} PUBLIC Eigen3::Eigen PRIVATE cpplus_build_flags)
  foreach(dependency ${arg_DEPENDS})
    target_link_libraries(cpplus_${name} PUBLIC cpplus_${dependency})
  endforeach()
  target_link_libraries(cpplus_${name} PRIVATE ${arg_LIBRARIES})
  set_target_properties(cpplus_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS cpplus_${name} EXPORT cpplusTargets)

  if(CPPLUS_BUILD_TESTS AND tests)
    add_executable(cpplus_${name}_test ${tests})
    cpplus_unity(cpplus_${name}_test)
    target_link_libraries(cpplus_${name}_test PRIVATE cpplus_${name} cpplus_build_flags GTest::gmock_main
                          ${arg_LIBRARIES} ${arg_TEST_LIBRARIES})
    target_compile_definitions(cpplus_${name}_test PRIVATE CPPLUS_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data")
    gtest_discover_tests(cpplus_${name}_test TEST_PREFIX "${name}/" TEST_FILTER "-Slow*"
                         PROPERTIES LABELS unit DISCOVERY_TIMEOUT 60)
    gtest_discover_tests(cpplus_${name}_test TEST_PREFIX "${name}/" TEST_FILTER "Slow*"
                         TEST_LIST cpplus_${name}_slow_tests PROPERTIES LABELS slow DISCOVERY_TIMEOUT 60)
  endif()
endfunction()
