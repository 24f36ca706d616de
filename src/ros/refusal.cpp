#include "refusal.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

namespace gms_ransac {

std::string toText(XmlRpc::XmlRpcValue value) {
  if (value.getType() == XmlRpc::XmlRpcValue::TypeString) return static_cast<std::string>(value);
  std::ostringstream text;
  value.write(text);
  return text.str();
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string oneOf(const std::vector<std::string>& choices) {
  std::string text = "one of";
  for (const std::string& choice : choices) text += " '" + choice + "'";
  return text;
}

std::string refusal(const std::string& name, const std::string& value, const std::string& accepted) {
  return "parameter " + name + " is '" + value + "'; it must be " + accepted;
}

[[noreturn]] void refuse(const ros::NodeHandle& pnh, const std::string& name, const std::string& value,
                         const std::string& accepted) {
  throw std::invalid_argument(refusal(pnh.resolveName(name), value, accepted));
}

}  // namespace gms_ransac
