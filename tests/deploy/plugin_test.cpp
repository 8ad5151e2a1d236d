// The MuJoCo plugin against the engine.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>

#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/xml.hpp"
#include "fricid/sim/plant.hpp"
#include "held_out.hpp"
#include "ignored_leaks.hpp"
#include "in_mujoco.hpp"
#include "plugin_errors.hpp"

namespace fricid::deploy::test {
namespace {

// The steps contract, so 1e-9 N m is the rounding of torques of 1e1 to 1e3 N m.
TEST(MujocoPlugin, EveryLawAndModifierIsTheEngine) {
  for (const data::ModelFile& model : all_robots()) {
    SCOPED_TRACE(model.name);
    const PluginErrors errors = plugin_errors(model);
    EXPECT_LE(errors.worst, 1e-9);
    // networks need not take energy: an arm that runs away is compared until then
    const auto& parameters = model.arm.friction.model.parameters();
    const bool may_drive =
        errors.steps > 50 && std::ranges::any_of(parameters, [](const auto& parameter) {
          return friction::is_weight(parameter.info.role);
        });
    EXPECT_TRUE(errors.steps == kPluginSteps || may_drive) << errors.steps;
    EXPECT_TRUE(errors.largest > 1e-3 || model.name == "none") << errors.largest;
  }
}

TEST(MujocoPlugin, FollowsTenSecondsOfHeldOutMotion) {
  for (const char* name : {"kr6_demo", "kr6_stickslip"}) {
    SCOPED_TRACE(name);
    const HeldOut held = held_out(name);
    const sim::Trace& trace = held.truth.trace;
    const double dt = held.truth.dt();
    const sim::MjModelPtr m = with_plugin(held.model);
    m->opt.timestep = held.physics_step;
    m->opt.disableflags |= mjDSBL_CONSTRAINT;
    const sim::MjDataPtr d = data_of(*m);
    const sim::State start = trace.state(0);
    std::ranges::copy(start.q, d->qpos);
    std::ranges::copy(start.v, d->qvel);
    std::ranges::copy(start.z, d->plugin_state);
    Shadow engine(held.model, *m, *d);
    const int per_sample = sim::steps_per_sample(dt, held.physics_step);
    const int length = std::min(trace.length(), static_cast<int>(10 / dt));
    ASSERT_GE(length * dt, 5);
    double worst = 0, apart = 0;
    for (int k = 0; k < length; ++k) {
      for (int j = 0; j < m->nv; ++j) {
        if (k * dt < 1) apart = std::max(apart, std::abs(d->qpos[j] - trace.q(k, j)));
        d->qfrc_applied[j] = trace.tau(k, j);
      }
      for (int s = 0; s < per_sample; ++s) {
        mj_step(m.get(), d.get());
        worst = std::max(worst, engine.compare(*d));
      }
    }
    EXPECT_LE(worst, 1e-9);
    EXPECT_LE(apart, 1e-6) << "the plant of the scene, in the first second";
  }
}

void run(const mjModel& m, mjData& d, int from, int to) {
  for (int k = from; k < to; ++k) {
    apply(m, d, k);
    mj_step(&m, &d);
  }
}

std::vector<double> state_of(const mjModel& m, const mjData& d) {
  std::vector<double> state(static_cast<std::size_t>(mj_stateSize(&m, mjSTATE_INTEGRATION)));
  mj_getState(&m, &d, state.data(), mjSTATE_INTEGRATION);
  return state;
}

TEST(MujocoPlugin, StateSurvivesGetStateCopyAndReset) {
  for (const char* name : {"gms", "load_on_gms"}) {
    const sim::MjModelPtr m = with_plugin(robot_with(name));
    const sim::MjDataPtr d = data_of(*m);
    const std::vector<double> rest = state_of(*m, *d);
    run(*m, *d, 0, 500);
    const std::vector<double> middle = state_of(*m, *d);
    EXPECT_TRUE(std::any_of(d->plugin_state, d->plugin_state + m->npluginstate,
                            [](double z) { return z != 0; }));
    const sim::MjDataPtr copy(mj_copyData(nullptr, m.get(), d.get()));
    run(*m, *d, 500, 700);
    const std::vector<double> end = state_of(*m, *d);

    run(*m, *copy, 500, 700);
    EXPECT_EQ(state_of(*m, *copy), end) << name << ", mj_copyData";
    mj_setState(m.get(), d.get(), middle.data(), mjSTATE_INTEGRATION);
    run(*m, *d, 500, 700);
    EXPECT_EQ(state_of(*m, *d), end) << name << ", mj_setState";
    mj_resetData(m.get(), d.get());
    EXPECT_EQ(state_of(*m, *d), rest) << name << ", mj_resetData";
    run(*m, *d, 0, 500);
    EXPECT_EQ(state_of(*m, *d), middle) << name << ", again";
  }
}

TEST(MujocoPlugin, ThreadsGiveTheSameBytes) {
  const sim::MjModelPtr m = with_plugin(robot_with("sum"));
  std::array<std::vector<double>, 4> ends;
  std::vector<std::thread> threads;
  for (std::vector<double>& end : ends)
    threads.emplace_back([&] {
      const sim::MjDataPtr d = data_of(*m);
      run(*m, *d, 0, 1000);
      end = state_of(*m, *d);
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& end : ends) EXPECT_EQ(end, ends[0]);
}

// What an actuator does is known after the passive forces of a step, so its share of the load is
// that of the step before.
TEST(MujocoPlugin, LoadIsAppliedForceAndTheActuatorsOfTheLastStep) {
  const data::ModelFile model = robot_with("load_on_gms");
  Exported exported = export_model(model, "plugin");
  std::string& text = exported.files[1].text;
  text.insert(text.rfind("</mujoco>"), "<actuator><motor joint=\"joint 1\"/></actuator>");
  const sim::MjModelPtr m = with_plugin(exported);
  const sim::MjDataPtr d = data_of(*m);
  Shadow engine(model, *m, *d);
  std::vector<double> load(2, 0.0);
  for (int k = 0; k < 500; ++k) {
    d->ctrl[0] = 20 * std::sin(0.01 * k);
    d->qfrc_applied[0] = 3;
    load[0] = 3 + d->qfrc_actuator[0];
    mj_step(m.get(), d.get());
    ASSERT_LE(engine.compare(*d, load), 1e-9) << k;
  }
}

TEST(MujocoPlugin, SaysInOneLineWhatIsWrong) {
  load_plugin();
  const auto refusal = [](const std::string& config, const std::string& joint) {
    const std::string text =
        "<mujoco><extension><plugin plugin=\"fricid.friction\"><instance name=\"f\">" + config +
        "</instance></plugin></extension><worldbody><body><joint name=\"" + joint +
        "\"/><geom size=\"1\"/></body></worldbody></mujoco>";
    const OwnFolder folder;
    write_file_atomically(folder.path() / "m.xml", text);
    std::array<char, 1000> error{};
    const IgnoredLeaks of_mujoco;  // whose mj_makeData keeps its memory when a plugin refuses
    try {
      const sim::MjModelPtr m(mj_loadXML((folder.path() / "m.xml").c_str(), nullptr, error.data(),
                                         static_cast<int>(error.size())));
      if (m) data_of(*m);
    } catch (const std::exception& thrown) {
      return std::string(thrown.what());
    }
    return std::string(error.data());
  };
  const auto config = [](const std::string& key, const std::string& value) {
    return Xml::of("<config key={} value={}/>", xml_attribute(key), xml_attribute(value)).text();
  };
  std::string content = data::model_text(robot_with("gms"));
  std::erase(content, '\n');
  const auto replaced = [&](const std::string& old, const std::string& by) {
    std::string text = content;
    const std::size_t at = text.find(old);
    return at == std::string::npos ? text : text.replace(at, old.size(), by);
  };
  const auto expect = [](const std::string& said, const std::string& part) {
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  expect(refusal("", "a"), "found none of the attributes model and content; allowed: one");
  expect(refusal(config("model", "/none.json"), "a"), "/none.json");
  expect(refusal(config("content", replaced("model/1", "model/2")), "a"), "is newer than");
  expect(refusal(config("content", "{"), "a"), "not JSON");
  expect(refusal(config("content", content), "a"), "the MJCF has no joint joint 1");
  expect(refusal(config("content", content) + config("prefix", "left "), "joint 1"),
         "the MJCF has no joint left joint 1");
  expect(refusal(config("content", content) + config("temperature", "hot"), "joint 1"),
         "temperature: found hot; allowed: above 0 [K]");
}

}  // namespace
}  // namespace fricid::deploy::test
