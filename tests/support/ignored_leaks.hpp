#pragma once

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace fricid {

/// What is allocated while one lives is not reported by the leak sanitizer: for libraries that
/// leak.
class IgnoredLeaks {
 public:
#ifdef __SANITIZE_ADDRESS__
  IgnoredLeaks() { __lsan_disable(); }
  ~IgnoredLeaks() { __lsan_enable(); }
#else
  IgnoredLeaks() {}
  ~IgnoredLeaks() {}
#endif
  IgnoredLeaks(const IgnoredLeaks&) = delete;
  IgnoredLeaks& operator=(const IgnoredLeaks&) = delete;
};

}  // namespace fricid
