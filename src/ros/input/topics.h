// The topics of the graph: inputs that are remapped to a topic of another type, and images published elsewhere.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace gms_ransac {

using Topics = std::map<std::string, std::string>;  ///< published topics: type by name

struct InputTopic {
  std::string name, topic, type;  ///< as remapped from; resolved; "package/Message"
};

/// One sentence for every input whose topic has another type, with the remedy; empty: none.
std::string wrongTypes(const std::vector<InputTopic>& inputs, const Topics& published);

/// "images are published on /a (image:=/a)": topics that the input `name` may be remapped to. Not those of `inputs`, in
/// use already, nor overlays of match filters; for depth/image those with depth in their names.
std::string imagesElsewhere(const Topics& published, const std::string& name, const std::vector<InputTopic>& inputs);

}  // namespace gms_ransac
