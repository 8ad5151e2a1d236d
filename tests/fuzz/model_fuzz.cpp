// libFuzzer target: a model file. A model that is read can be written, read again and simulated.
#include "fricid/base/files.hpp"
#include "fricid/data/model_file.hpp"
#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace fricid;
  static const fuzz::Folder folder;
  fuzz::write("model.json", fuzz::text_of(data, size));
  std::optional<data::ModelFile> model;
  if (!fuzz::reads({"model.json"}, [&] { model = data::load_model("model.json"); })) return 0;

  data::save_model(*model, "one.json");
  data::save_model(data::load_model("one.json"), "other.json");
  fuzz::require_same("the model", read_file("one.json"), read_file("other.json"));

  const auto n = static_cast<std::size_t>(model->arm.robot.n());
  const std::vector<double> tau(n, 1.0), temperature(n, 300.0);
  std::vector<double> q(n, 0.1), v(n, -0.1),
      z(static_cast<std::size_t>(model->arm.friction.model.state_size()), 0.0);
  ArmStepper<double>(model->arm, {8, 4}).step(tau, temperature, 0.004, q, v, z);
  return 0;
}
