// libFuzzer target: a contract, and a log that is read by it.
#include "fricid/data/contract.hpp"
#include "log_samples.hpp"
#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace fricid;
  static const fuzz::Folder folder;
  static const bool beside = [] {
    for (const data::LogSample& sample : data::log_samples(8))
      if (sample.format == "csv") fuzz::write("log.csv", sample.files[0].second);
    return true;
  }();
  (void)beside;
  fuzz::write("contract.toml", fuzz::text_of(data, size));
  fuzz::reads({"contract.toml", "log.csv"}, [] {
    const data::Contract contract = data::load_contract("contract.toml");
    data::import_log("log.csv", contract);
  });
  return 0;
}
