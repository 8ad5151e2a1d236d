#include "shared_library.hpp"

#include <dlfcn.h>

#include <utility>

#include "fricid/base/error.hpp"

namespace fricid::film {

SharedLibrary::SharedLibrary(std::string name, const std::string& package)
    // stays in memory: what the library keeps until the end is its own
    : name_(std::move(name)),
      handle_(dlopen(name_.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) {
  if (!handle_) throw UserError("{} is missing; install {}", name_, package);
}

SharedLibrary::~SharedLibrary() { dlclose(handle_); }

void SharedLibrary::publish() const {
  // stays open, since its functions may still be in use
  dlopen(name_.c_str(), RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
}

void* SharedLibrary::find(const char* symbol) const {
  void* address = dlsym(handle_, symbol);
  if (!address) throw UserError("{} has no {}", name_, symbol);
  return address;
}

}  // namespace fricid::film
