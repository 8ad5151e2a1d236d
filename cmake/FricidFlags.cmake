# Flags of every target of this project.

set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()

if(PROJECT_IS_TOP_LEVEL)
  include(FricidCcache)
endif()

if(NOT FRICID_ARCH MATCHES "^(native|x86-64-v3|x86-64-v4)$")
  message(FATAL_ERROR "FRICID_ARCH = ${FRICID_ARCH}; allowed: native, x86-64-v3, x86-64-v4")
endif()

# What a consumer must compile with too: Pack and Eigen types cross the border, so one -march
# for all; -ffp-contract=off keeps results independent of how the compiler fuses.
set(fricid_float_options -ffp-contract=off -fno-math-errno -fno-trapping-math)
add_library(fricid_abi INTERFACE)
add_library(fricid::fricid_abi ALIAS fricid_abi)
target_compile_features(fricid_abi INTERFACE cxx_std_20)
target_compile_options(fricid_abi INTERFACE -march=${FRICID_ARCH} ${fricid_float_options})

# Warnings and sanitizers: ours alone.
add_library(fricid_flags INTERFACE)
target_compile_options(fricid_flags INTERFACE -Wall -Wextra -Wconversion -Wshadow -Wno-psabi)
# What g++ 12 says falsely: uninitialised values and accesses out of bounds in its own AVX-512 headers
# (GCC bug 105593) and in arrays of no elements, and copies of strings beyond their end in a
# precompiled standard library. The sanitizers and clang-tidy look for the true ones.
target_compile_options(fricid_flags INTERFACE
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized;-Wno-maybe-uninitialized;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
# GCC else copies structs by halves of a 64-byte lane pack, which stalls the load of the whole one.
target_compile_options(fricid_flags INTERFACE
  $<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,12>>:-mmove-max=512;-mstore-max=512>)
# GCC collects its garbage from 512 MB on, not 128 MB: units of Eigen pass that all the same, and the tenth of
# the time that the collections before it take is saved.
target_compile_options(fricid_flags INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=524288>)
if(FRICID_WERROR)
  target_compile_options(fricid_flags INTERFACE -Werror)
endif()

# Address and undefined-behaviour sanitizers: of all that is ours by FRICID_SANITIZE, else of the
# targets that link this.
add_library(fricid_sanitizers INTERFACE)
target_compile_options(
  fricid_sanitizers
  INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1)
target_link_options(fricid_sanitizers INTERFACE -fsanitize=address,undefined)
if(FRICID_FUZZ)
  target_compile_options(fricid_sanitizers INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(FRICID_SANITIZE)
  target_link_libraries(fricid_flags INTERFACE fricid_sanitizers)
  target_link_options(fricid_abi INTERFACE -fsanitize=address,undefined)
endif()
