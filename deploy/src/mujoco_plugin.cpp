// Friction for the engine plugin of MuJoCo, sim/plugin.
#include <fmt/format.h>

#include "fricid/deploy/c_header.hpp"
#include "mjcf.hpp"
#include "writers.hpp"

namespace fricid::deploy {
namespace {

// The model file in one line: line ends are between its values only.
std::string in_one_line(const data::ModelFile& model) {
  std::string text;
  bool indents = false;
  for (const char c : data::model_text(model)) {
    indents = c == '\n' || (indents && c == ' ');
    if (!indents) text += c;
  }
  return text;
}

}  // namespace

Exported write_plugin(const data::ModelFile& model) {
  const std::string name = code_name(model), extension = name + "_extension.xml";
  const Xml text = Xml::of(
      "<mujoco>\n<extension>\n<plugin plugin=\"fricid.friction\">\n<instance name={}>\n"
      "<config key=\"content\" value={}/>\n</instance>\n</plugin>\n</extension>\n</mujoco>\n",
      xml_attribute(name + " friction"), xml_attribute(in_one_line(model)));
  return {.files = {{extension, text.text()},
                    {name + "_plugin.xml",
                     mjcf_text(model, {.rest = Xml::of("<include file={}/>\n",
                                                       xml_attribute(extension))})}},
          .losses = torques_left_out(model.arm.robot, true)};
}

}  // namespace fricid::deploy
