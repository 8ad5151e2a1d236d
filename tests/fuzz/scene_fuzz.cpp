// libFuzzer target: a scene, beside a robot, its MJCF and a contract. What is read is written again
// by `fricid run`, so that must read as the same scene.
#include "fricid/scene/problem.hpp"
#include "target.hpp"
#include "two_link_arm.hpp"

namespace {

using namespace fricid;

std::string as_run(const char* file) { return scene::to_toml(scene::load_problem(file).scene); }

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const bool beside = [] {
    fuzz::write("arm.urdf", kArmUrdf);
    fuzz::write("arm.xml", "<mujoco/>");
    fuzz::write("base.toml", "[identify]\ncutoff_hz = 8\n");
    fuzz::write("contract.toml",
                "joint_names = [\"shoulder\", \"elbow\"]\n[position]\ncolumns = "
                "\"q{}\"\n[torque]\ncolumns = \"tau{}\"\n");
    return true;
  }();
  (void)beside;
  fuzz::write("scene.toml", fuzz::text_of(data, size));
  std::string first;
  if (!fuzz::reads({"scene.toml", "base.toml", "arm.urdf", "contract.toml", "/", "."},
                   [&] { first = as_run("scene.toml"); }))
    return 0;
  fuzz::write("again.toml", first);
  fuzz::require_same("the scene as run", first, as_run("again.toml"));
  return 0;
}
