// The sentences with which a parameter is refused.
#pragma once

#include <string>
#include <vector>

namespace ros {
class NodeHandle;
}
namespace XmlRpc {
class XmlRpcValue;
}

namespace gms_ransac {

std::string toText(XmlRpc::XmlRpcValue value);

bool contains(const std::vector<std::string>& words, const std::string& word);

/// "one of 'a' 'b'"
std::string oneOf(const std::vector<std::string>& choices);

std::string refusal(const std::string& name, const std::string& value, const std::string& accepted);

/// Throws std::invalid_argument with the refusal of a parameter in the namespace of `pnh`.
[[noreturn]] void refuse(const ros::NodeHandle& pnh, const std::string& name, const std::string& value,
                         const std::string& accepted);

}  // namespace gms_ransac
