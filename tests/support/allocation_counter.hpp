#pragma once

namespace fricid::test {

/// Number of calls of operator new so far, in a program that links allocation_counter.cpp.
long allocation_count();

}  // namespace fricid::test
