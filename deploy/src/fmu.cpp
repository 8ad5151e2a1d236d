// Friction as an FMU: FMI 3.0, co-simulation.
#include <fmt/format.h>
#include <stdlib.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>

#include "fmu_source.hpp"
#include "fricid/base/files.hpp"
#include "fricid/base/processes.hpp"
#include "fricid/base/xml.hpp"
#include "fricid/deploy/c_header.hpp"
#include "writers.hpp"
#include "zip.hpp"

namespace fricid::deploy {
namespace {

namespace fs = std::filesystem;

#if defined(__aarch64__)
constexpr const char* kPlatform = "aarch64-linux";
#else
constexpr const char* kPlatform = "x86_64-linux";
#endif

/// A field of every joint, in the order of value references (fmu_source.cpp).
struct Variable {
  const char *name, *unit, *unit_of_slide, *attributes, *meaning;
};
constexpr std::array kVariables{
    Variable{"q", "rad", "m", "causality=\"input\" start=\"0\"", "position"},
    Variable{"v", "rad/s", "m/s", "causality=\"input\" start=\"0\"", "velocity"},
    Variable{"load", "N.m", "N", "causality=\"input\" start=\"0\"", "motor torque"},
    Variable{"temperature", "K", "K", "causality=\"input\" start=\"293.15\"", "temperature"},
    Variable{"tau_f", "N.m", "N", "causality=\"output\" initial=\"calculated\"",
             "friction torque, above 0 against v above 0"}};

/// Of a joint that slides m, m/s, N.
const char* unit_of(const Variable& variable, const dynamics::Joint& joint) {
  return dynamics::slides(joint) ? variable.unit_of_slide : variable.unit;
}

Xml literal(const char* text) { return Xml(Vouched{text}); }

std::string model_description(const data::ModelFile& model, const std::string& name,
                              const std::string& token) {
  const auto& joints = model.arm.robot.joints;
  const std::size_t n = joints.size();
  Xml variables, outputs;
  std::size_t reference = 1;
  for (const Variable& variable : kVariables)
    for (const dynamics::Joint& joint : joints) {
      variables += Xml::of(
          "  <Float64 name={} valueReference=\"{}\" {} variability=\"continuous\" "
          "unit=\"{}\" description={}/>\n",
          xml_attribute(joint.name + "." + variable.name), reference, literal(variable.attributes),
          literal(unit_of(variable, joint)), xml_attribute(variable.meaning));
      ++reference;
    }
  const auto states = static_cast<std::size_t>(model.arm.friction.model.state_size());
  for (std::size_t i = 0; i < states; ++i)
    variables += Xml::of(
        "  <Float64 name=\"z[{}]\" valueReference=\"{}\" causality=\"local\" initial=\"exact\" "
        "start=\"0\" variability=\"continuous\" description=\"state of the friction\"/>\n",
        i + 1, reference + i);
  for (const char* element : {"Output", "InitialUnknown"})
    for (std::size_t j = 0; j < n; ++j)
      outputs += Xml::of("  <{} valueReference=\"{}\"/>\n", literal(element), 4 * n + j + 1);
  return Xml::of(
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
             "<fmiModelDescription fmiVersion=\"3.0\" modelName={} instantiationToken=\"{}\" "
             "generationTool=\"fricid\" description={}>\n"
             "<CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" "
             "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"/>\n"
             "<UnitDefinitions>\n"
             "  <Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>\n"
             "  <Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit>\n"
             "  <Unit name=\"N.m\"><BaseUnit kg=\"1\" m=\"2\" s=\"-2\"/></Unit>\n"
             "  <Unit name=\"m\"><BaseUnit m=\"1\"/></Unit>\n"
             "  <Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit>\n"
             "  <Unit name=\"N\"><BaseUnit kg=\"1\" m=\"1\" s=\"-2\"/></Unit>\n"
             "  <Unit name=\"K\"><BaseUnit K=\"1\"/></Unit>\n"
             "  <Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n"
             "</UnitDefinitions>\n"
             "<DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"0.001\"/>\n"
             "<ModelVariables>\n"
             "  <Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" "
             "variability=\"continuous\" unit=\"s\"/>\n{}</ModelVariables>\n"
             "<ModelStructure>\n{}</ModelStructure>\n</fmiModelDescription>\n",
             xml_attribute(name), literal(token.c_str()),
             xml_attribute(fmt::format("joint friction of {}{}{}", title_of(model),
                                       model.arm.robot.coupled() ? ": " : "",
                                       coordinates_in_words(model.arm.robot))),
             literal(name.c_str()), variables, outputs)
      .text();
}

/// A folder that is removed with the object.
class Workshop {
 public:
  Workshop() {
    std::string pattern = (fs::temp_directory_path() / "fricid_XXXXXX").string();
    if (::mkdtemp(pattern.data())) path_ = pattern;
  }
  ~Workshop() {
    std::error_code error;
    if (!path_.empty()) fs::remove_all(path_, error);
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// The shared library of the sources; nothing where there is no C compiler.
std::optional<std::string> compiled(const std::string& name, const std::string& header,
                                    const std::string& source) {
  const Workshop folder;
  if (folder.path().empty()) return {};
  const fs::path library = folder.path() / "library.so";
  std::ofstream(folder.path() / (name + "_friction.h")) << header;
  std::ofstream(folder.path() / "fmu.c") << source;
  const int id = start_program(
      {"cc", "-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared",
       "-Wl,--build-id=none", "-o", library.string(), (folder.path() / "fmu.c").string(), "-lm"},
      {});
  if (id == 0 || wait_for_process(id) != 0) return {};
  return read_file(library);
}

}  // namespace

Exported write_fmu(const data::ModelFile& model) {
  const std::string name = code_name(model), header = c_header(model);
  const std::string token = sha256_of_text(header), source = fmu_source(name, token);
  const std::string build = Xml::of(
                                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                                "<fmiBuildDescription fmiVersion=\"3.0\">\n"
                                "<BuildConfiguration modelIdentifier=\"{}\">\n"
                                "<SourceFileSet language=\"C99\"><SourceFile name=\"fmu.c\"/>"
                                "</SourceFileSet>\n<Library name=\"m\"/>\n"
                                "</BuildConfiguration>\n</fmiBuildDescription>\n",
                                literal(name.c_str()))
                                .text();
  std::vector<TextFile> files{{"modelDescription.xml", model_description(model, name, token)},
                              {"sources/buildDescription.xml", build},
                              {"sources/fmu.c", source},
                              {"sources/" + name + "_friction.h", header}};
  Exported exported{.files = {}, .losses = torques_left_out(model.arm.robot, false)};
  if (auto library = compiled(name, header, source))
    files.push_back({fmt::format("binaries/{}/{}.so", kPlatform, name), std::move(*library)});
  else
    exported.losses.emplace_back("there is no C compiler `cc`, so the FMU has sources alone");
  if (model.arm.robot.coupled()) exported.losses.push_back(coordinates_in_words(model.arm.robot));
  exported.files.push_back({name + ".fmu", zip(files)});
  return exported;
}

}  // namespace fricid::deploy
