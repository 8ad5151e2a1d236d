#include "cairo_library.hpp"

#include <type_traits>

#include "shared_library.hpp"

namespace fricid::film {

const CairoLibrary& cairo() {
  static const SharedLibrary library("libcairo.so.2", "libcairo2");
  static const CairoLibrary functions{
#define FRICID_CAIRO_FIND(name) \
  .name = library.function<std::remove_pointer_t<decltype(CairoLibrary::name)>>("cairo_" #name),
      FRICID_CAIRO_FUNCTIONS(FRICID_CAIRO_FIND)
#undef FRICID_CAIRO_FIND
  };
  return functions;
}

}  // namespace fricid::film
