# Code for a program as for a shared library (the Python module). Hidden symbols keep calls within it
# as direct as in a program.
function(fricid_position_independent target)
  target_compile_options(${target} PRIVATE -fPIC)
  set_target_properties(${target} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# What the libraries after friction include, compiled once: the standard library, Eigen, fmt, and the
# declarations of the parts of Eigen that base has compiled.
function(fricid_precompile_headers)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/headers.cpp CONTENT "")
  add_library(fricid_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/headers.cpp)
  fricid_position_independent(fricid_headers)
  target_link_libraries(fricid_headers PRIVATE fricid_abi fricid_flags fricid_base Eigen3::Eigen fmt::fmt)
  target_precompile_headers(
    fricid_headers PRIVATE <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map>
                           <memory> <numbers> <optional> <span> <string> <string_view> <utility>
                           <vector> <fmt/format.h> <Eigen/Core> <fricid/base/eigen_instances.hpp>)
endfunction()

# Lets a target use them.
function(fricid_use_precompiled_headers target)
  target_precompile_headers(${target} REUSE_FROM fricid_headers)
  target_link_libraries(${target} PRIVATE fricid_base)
endfunction()

# fricid_library(NAME SOURCES files... [PUBLIC targets...] [PRIVATE targets...])
# A static library fricid::NAME with the headers of ./include, and nothing visible but what it names.
function(fricid_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(fricid_${name} STATIC ${arg_SOURCES})
  add_library(fricid::${name} ALIAS fricid_${name})
  set_target_properties(fricid_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(
    fricid_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                          $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  fricid_position_independent(fricid_${name})
  target_link_libraries(fricid_${name} PUBLIC fricid_abi ${arg_PUBLIC}
                                       PRIVATE $<BUILD_INTERFACE:fricid_flags> ${arg_PRIVATE})
  if(TARGET fricid_headers)
    fricid_use_precompiled_headers(fricid_${name})
  endif()
  if(FRICID_UNITY_BUILD)
    set_target_properties(fricid_${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  endif()
  set_property(GLOBAL APPEND PROPERTY FRICID_LIBRARIES fricid_${name})
  set_property(GLOBAL APPEND PROPERTY FRICID_INCLUDE_DIRS ${CMAKE_CURRENT_SOURCE_DIR}/include)
endfunction()

# fricid_options(NAME [targets...])
# The options of a library, fricid::NAME_options: headers alone, in ./options/include. A scene embeds
# them without seeing the library.
function(fricid_options name)
  add_library(fricid_${name}_options INTERFACE)
  add_library(fricid::${name}_options ALIAS fricid_${name}_options)
  set_target_properties(fricid_${name}_options PROPERTIES EXPORT_NAME ${name}_options)
  target_include_directories(
    fricid_${name}_options INTERFACE $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/options/include>
                                     $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(fricid_${name}_options INTERFACE fricid::base ${ARGN})
  set_property(GLOBAL APPEND PROPERTY FRICID_LIBRARIES fricid_${name}_options)
  set_property(GLOBAL APPEND PROPERTY FRICID_INCLUDE_DIRS ${CMAKE_CURRENT_SOURCE_DIR}/options/include)
endfunction()

# Flags of every test. Tests wait for the compiler more than for the processor. With ARCH: for another
# instruction set than that of the libraries, none of which it may use then.
function(fricid_test_flags target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "ARCH" "")
  set(abi fricid_abi)
  if(arg_ARCH)
    set(abi)
    target_compile_features(${target} PRIVATE cxx_std_20)
    target_compile_options(${target} PRIVATE -march=${arg_ARCH} ${fricid_float_options})
  endif()
  target_link_libraries(${target} PRIVATE GTest::gmock_main ${abi} fricid_flags)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# What all tests include, compiled once.
function(fricid_precompile_test_headers)
  find_package(Eigen3 3.4 REQUIRED NO_MODULE)
  find_package(fmt REQUIRED)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/test_headers.cpp CONTENT "")
  add_library(fricid_test_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/test_headers.cpp)
  fricid_test_flags(fricid_test_headers)
  target_link_libraries(fricid_test_headers PRIVATE Eigen3::Eigen fmt::fmt)
  target_precompile_headers(fricid_test_headers PRIVATE <gmock/gmock.h> <gtest/gtest.h>
                            <Eigen/Dense> <fmt/format.h> <filesystem> <functional> <map> <random>
                            <sstream>)
endfunction()

# fricid_test(NAME SOURCES files... DEPENDS targets... [LABEL label] [TIMEOUT seconds] [TOGETHER suite])
# One GoogleTest program, one CTest entry per TEST(), but one for all tests of a suite that share what takes most of their time.
function(fricid_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL;TIMEOUT;TOGETHER" "SOURCES;DEPENDS")
  if(NOT arg_LABEL)
    set(arg_LABEL unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  if(FRICID_SANITIZE)
    math(EXPR arg_TIMEOUT "15 * ${arg_TIMEOUT}")
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE fricid_source_dir ${arg_DEPENDS})
  fricid_test_flags(${name})
  target_precompile_headers(${name} REUSE_FROM fricid_test_headers)
  # Four files as one unit: half the time, since they include and instantiate the same. What replaces
  # operator new stays alone, or the compiler sees through it.
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 4)
  list(FILTER arg_SOURCES INCLUDE REGEX "counter\\.cpp$")
  set_source_files_properties(${arg_SOURCES} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set(apart)
  if(arg_TOGETHER)
    set(apart TEST_FILTER "-${arg_TOGETHER}.*")
    add_test(NAME ${arg_TOGETHER} COMMAND ${name} "--gtest_filter=${arg_TOGETHER}.*")
    # begun early: it is long
    set_tests_properties(${arg_TOGETHER} PROPERTIES LABELS ${arg_LABEL} TIMEOUT ${arg_TIMEOUT} COST 500)
  endif()
  gtest_discover_tests(${name} ${apart} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS ${arg_LABEL} TIMEOUT ${arg_TIMEOUT})
endfunction()
