#pragma once

namespace fricid::smc::test {

/// Blocks taken from the heap so far, by operator new or by Eigen: in a program that links
/// malloc_counter.cpp and allocation_counter.cpp with --wrap for malloc and its kin.
long heap_blocks();

}  // namespace fricid::smc::test
