// Model, Friction: a model file, and its friction on batches.
#include "model.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <utility>

#include "arrays.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/pack.hpp"
#include "fricid/base/unit_of_joint.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/system/driven_friction.hpp"

namespace fricid::python {
namespace {

namespace fs = std::filesystem;
using OptionalArray = std::optional<ArrayLike>;

constexpr Eigen::Index kLanes = PackD::kLanes;

/// Friction of a model on batches: rows are independent states.
class Friction {
 public:
  explicit Friction(std::shared_ptr<const data::ModelFile> file) : file_(std::move(file)) {
    for (const double value : friction().theta) theta_.emplace_back(value);
  }

  int n() const { return friction().model.joint_count(); }
  int state_size() const { return friction().model.state_size(); }
  nb::ndarray<nb::numpy, double> motors_of_joints() const {
    return to_numpy(file_->arm.robot.motors_of_joints(), false);
  }

  nb::list parameters() const {
    nb::list rows;
    const auto& all = friction().model.parameters();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const friction::ParameterRef& p = all[i];
      nb::dict row;
      const dynamics::Joint* joint =
          p.joint == friction::kWholeRobot
              ? nullptr
              : &file_->arm.robot.joints[static_cast<std::size_t>(p.joint)];
      row["joint"] = joint ? joint->name : std::string();
      row["owner"] = p.owner;
      row["symbol"] = p.symbol;
      row["value"] = friction().theta[i];
      row["unit"] = unit_of_joint(p.info.unit, joint && slides(*joint));
      row["meaning"] = std::string(p.info.meaning);
      rows.append(row);
    }
    return rows;
  }

  nb::ndarray<nb::numpy, double> rest(int count) const {
    if (count < 0) throw UserError("rest: {} states; allowed: 0 or more", count);
    return to_numpy(RowMatrix::Zero(std::max(count, 1), state_size()), count == 0);
  }

  nb::ndarray<nb::numpy, double> torque(const ArrayLike& q, const ArrayLike& v, const ArrayLike& z,
                                        const OptionalArray& load,
                                        const OptionalArray& temperature) const {
    const Batch batch(*this, q, v, &z, load, temperature);
    RowMatrix tau_f(batch.count, n());
    {
      const nb::gil_scoped_release released;
      batch.for_each_pack([&](Eigen::Index row, Lanes& lanes) {
        friction().model.torque<PackD>(theta_, lanes.in, lanes.z, lanes.tau_f);
        batch.put(lanes.tau_f, row, tau_f);
      });
    }
    return to_numpy(std::move(tau_f), batch.is_one);
  }

  nb::ndarray<nb::numpy, double> step(const ArrayLike& q, const ArrayLike& v, const ArrayLike& z,
                                      double dt, const OptionalArray& load,
                                      const OptionalArray& temperature) const {
    if (!(dt > 0)) throw UserError("dt = {} s; allowed: above 0", dt);
    const Batch batch(*this, q, v, &z, load, temperature);
    RowMatrix next(batch.count, state_size());
    {
      const nb::gil_scoped_release released;
      batch.for_each_pack([&](Eigen::Index row, Lanes& lanes) {
        friction().model.step<PackD>(theta_, lanes.in, dt, lanes.z);
        batch.put(lanes.z, row, next);
      });
    }
    return to_numpy(std::move(next), batch.is_one);
  }

  nb::ndarray<nb::numpy, double> steady_torque(const ArrayLike& q, const ArrayLike& v,
                                               const OptionalArray& load,
                                               const OptionalArray& temperature) const {
    const Batch batch(*this, q, v, nullptr, load, temperature);
    RowMatrix tau_f(batch.count, n());
    {
      const nb::gil_scoped_release released;
      batch.for_each_pack([&](Eigen::Index row, Lanes& lanes) {
        friction().model.steady_torque<PackD>(theta_, lanes.in, lanes.tau_f);
        batch.put(lanes.tau_f, row, tau_f);
      });
    }
    return to_numpy(std::move(tau_f), batch.is_one);
  }

  std::pair<nb::ndarray<nb::numpy, double>, nb::ndarray<nb::numpy, double>> drive(
      const ArrayLike& q, const ArrayLike& v, double dt, const OptionalArray& load,
      const OptionalArray& temperature, const OptionalArray& z0) const {
    if (!(dt > 0)) throw UserError("dt = {} s; allowed: above 0", dt);
    const Batch motion(*this, q, v, nullptr, load, temperature);
    const auto along = [&](const Rows& rows) {
      return RowMatrix(rows.matrix().replicate(rows.count() == 1 ? motion.count : 1, 1));
    };
    const Rows start = z0 ? Rows(*z0, "z0", state_size()) : Rows(0, state_size());
    if (start.count() != 1) throw UserError("z0 has {} rows; allowed: one state", start.count());
    DrivenFriction driven;
    {
      const nb::gil_scoped_release released;
      driven = drive_friction(friction(), dt, along(motion.q), along(motion.v), along(motion.load),
                              along(motion.temperature),
                              {start.row(0), static_cast<std::size_t>(state_size())});
    }
    return {to_numpy(std::move(driven.tau_f)), to_numpy(std::move(driven.z))};
  }

 private:
  const friction::Friction& friction() const { return file_->arm.friction; }

  /// A pack of rows.
  struct Lanes {
    std::vector<friction::Input<PackD>> in;
    std::vector<PackD> z, tau_f;
  };

  /// Arrays of one call: each has one row, or as many as the batch.
  struct Batch {
    Rows q, v, z, load, temperature;
    Eigen::Index count = 1;
    bool is_one = true;

    Batch(const Friction& f, const ArrayLike& q_in, const ArrayLike& v_in, const ArrayLike* z_in,
          const OptionalArray& load_in, const OptionalArray& temperature_in)
        : q(q_in, "q", f.n()),
          v(v_in, "v", f.n()),
          z(z_in ? Rows(*z_in, "z", f.state_size()) : Rows(0, f.state_size())),
          load(load_in ? Rows(*load_in, "load", f.n()) : Rows(0, f.n())),
          temperature(temperature_in ? Rows(*temperature_in, "temperature", f.n())
                                     : Rows(kRoomTemperature, f.n())) {
      const std::pair<const char*, const Rows*> all[] = {
          {"q", &q}, {"v", &v}, {"z", &z}, {"load", &load}, {"temperature", &temperature}};
      const char* longest = "q";
      for (const auto& [name, rows] : all) {
        is_one = is_one && rows->is_one();
        if (rows->is_one()) continue;
        if (count != 1 && rows->count() != count && rows->count() != 1)
          throw UserError("{} has {} rows; allowed: 1 or {}, as {} has", name, rows->count(), count,
                          longest);
        if (rows->count() != 1) {
          count = rows->count();
          longest = name;
        }
      }
    }

    /// Calls body(first row, lanes) for every pack of rows; the last one repeats its last row.
    template <class Body>
    void for_each_pack(const Body& body) const {
      Lanes lanes;
      const auto n = static_cast<std::size_t>(q.matrix().cols());
      lanes.in.resize(n);
      lanes.tau_f.resize(n);
      lanes.z.resize(static_cast<std::size_t>(z.matrix().cols()));
      for (Eigen::Index first = 0; first < count; first += kLanes) {
        for (int l = 0; l < kLanes; ++l) {
          const Eigen::Index row = std::min(first + l, count - 1);
          for (std::size_t j = 0; j < n; ++j) {
            set_lane(lanes.in[j].q, l, q.row(row)[j]);
            set_lane(lanes.in[j].v, l, v.row(row)[j]);
            set_lane(lanes.in[j].load, l, load.row(row)[j]);
            set_lane(lanes.in[j].temperature, l, temperature.row(row)[j]);
          }
          for (std::size_t s = 0; s < lanes.z.size(); ++s) set_lane(lanes.z[s], l, z.row(row)[s]);
        }
        body(first, lanes);
      }
    }

    /// Copies the lanes of a pack into its rows.
    void put(const std::vector<PackD>& lanes, Eigen::Index first, RowMatrix& rows) const {
      for (int l = 0; l < std::min(kLanes, count - first); ++l)
        for (std::size_t j = 0; j < lanes.size(); ++j)
          rows(first + l, static_cast<Eigen::Index>(j)) = lane(lanes[j], l);
    }
  };

  std::shared_ptr<const data::ModelFile> file_;
  std::vector<PackD> theta_;  // in every lane
};

/// @return the files, and what the format leaves out
std::pair<std::vector<fs::path>, std::vector<std::string>> export_model(const Model& model,
                                                                        const std::string& format,
                                                                        const fs::path& folder) {
  const deploy::Exported exported = deploy::export_model(*model.file, format);
  deploy::save(exported, folder);
  std::vector<fs::path> files;
  for (const deploy::TextFile& file : exported.files) files.push_back(folder / file.name);
  return {files, exported.losses};
}

}  // namespace

nb::class_<Model> bind_model(nb::module_& m) {
  using nb::literals::operator""_a;

  nb::class_<Friction>(
      m, "Friction",
      "Friction of a robot: a torque for every joint, and internal states z.\n\n"
      "Where motors are coupled, q, v, load and torques are those of the motors, with C = "
      "motors_of_joints: q @ C.T and v @ C.T of joints q, v; tau @ C are the joints' torques.\n\n"
      "Arrays are (n) or (N, n), joints or states along the last axis; (n) is used "
      "for every row. load is the torque through the gear [N m], zero if not "
      "given; temperature [K] is room temperature if not given.")
      .def_prop_ro("n", &Friction::n, "Number of joints.")
      .def_prop_ro("motors_of_joints", &Friction::motors_of_joints, nb::rv_policy::copy,
                   "C (n, n): angles of the motors C q of joint angles q; unity without coupling.")
      .def_prop_ro("state_size", &Friction::state_size, "Number of states, all joints together.")
      .def_prop_ro("parameters", &Friction::parameters,
                   nb::sig("def parameters(self) -> list[dict[str, object]]"),
                   "One dict per parameter: joint, owner, symbol, value, unit, meaning.")
      .def("rest", &Friction::rest, "count"_a = 0,
           "States of zero: (state_size), or (count, state_size).")
      .def("torque", &Friction::torque, "q"_a, "v"_a, "z"_a, "load"_a = nb::none(),
           "temperature"_a = nb::none(),
           "Friction torque [N m] at positions q [rad], velocities v [rad/s] and states z.")
      .def("step", &Friction::step, "q"_a, "v"_a, "z"_a, "dt"_a, "load"_a = nb::none(),
           "temperature"_a = nb::none(), "The states after dt [s] with the inputs held.")
      .def("steady_torque", &Friction::steady_torque, "q"_a, "v"_a, "load"_a = nb::none(),
           "temperature"_a = nb::none(), "Limit of `torque` [N m] at constant inputs; 0 at v = 0.")
      .def(
          "drive", &Friction::drive, "q"_a, "v"_a, "dt"_a, "load"_a = nb::none(),
          "temperature"_a = nb::none(), "z0"_a = nb::none(),
          "Torque (T, n) and states (T, state_size) along a motion q, v (T, n), dt [s] apart, from "
          "z0, rest if not given.");

  nb::class_<Model> model(m, "Model",
                          "An identified robot: rigid body, friction and, if fitted, noise.");
  model
      .def_static(
          "load",
          [](const fs::path& path) {
            return Model{std::make_shared<const data::ModelFile>(data::load_model(path))};
          },
          "path"_a, "A model file, such as those in models/ of a run.")
      .def(
          "save", [](const Model& self, const fs::path& path) { save_model(*self.file, path); },
          "path"_a, "Writes the model, with the same bytes as the file it was loaded from.")
      .def_prop_ro(
          "name", [](const Model& self) { return self.file->name; }, "As in the scene: \"lugre\".")
      .def_prop_ro(
          "label", [](const Model& self) { return self.file->label; }, "For tables and plots.")
      .def_prop_ro(
          "seed", [](const Model& self) { return self.file->seed; }, "Of the fit.")
      .def_prop_ro(
          "free_parameters", [](const Model& self) { return self.file->free_parameters; },
          "Number of fitted values.")
      .def_prop_ro(
          "joint_names", [](const Model& model) { return model.file->arm.robot.joint_names(); },
          "In the order of all arrays.")
      .def_prop_ro(
          "friction", [](const Model& self) { return Friction(self.file); },
          "The friction of all joints.")
      .def("export", &export_model, "format"_a, "folder"_a,
           fmt::format("Writes the model in a format of `fricid export`: {}. Returns the files and "
                       "what the format leaves out.",
                       deploy::format_list())
               .c_str())
      .def("__repr__", [](const Model& self) {
        return fmt::format("<fricid.Model {} seed {}, {} joints>", self.file->name, self.file->seed,
                           self.file->arm.robot.n());
      });
  return model;
}

}  // namespace fricid::python
