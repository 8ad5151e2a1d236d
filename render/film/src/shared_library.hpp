#pragma once

#include <string>

namespace fricid::film {

/// A shared library opened at run time.
class SharedLibrary {
 public:
  /// @param package  what to install where the library is missing
  /// @throws UserError naming library and package
  SharedLibrary(std::string name, const std::string& package);
  ~SharedLibrary();
  SharedLibrary(const SharedLibrary&) = delete;
  SharedLibrary& operator=(const SharedLibrary&) = delete;

  /// @throws UserError when the library has no such function
  template <class Function>
  Function* function(const char* symbol) const {
    return reinterpret_cast<Function*>(find(symbol));
  }

  /// Makes its functions visible to the other libraries of the process.
  void publish() const;

 private:
  void* find(const char* symbol) const;

  std::string name_;
  void* handle_;
};

}  // namespace fricid::film
