#include "fricid/base/files.hpp"
#include "run_folder_docs.hpp"

int main(int, char** argv) {
  fricid::write_file_atomically(argv[1], fricid::run_folder_page());
  return 0;
}
