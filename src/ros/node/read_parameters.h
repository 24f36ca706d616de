// All parameters of the node from the parameter server, checked against cfg/parameters.py.
#pragma once

#include <string>
#include <vector>

#include "output/output_options.h"
#include "parameters.h"
#include "parameters/parameter.h"
#include "stream/stream.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

/// The options that answer an image: those of the core, and the parameters in cfg/MatchFilter.cfg, which can change.
struct RuntimeOptions {
  ProcessorOptions processor;
  OutputOptions outputs;
};

const ParameterTable& startParameters();
const ParameterTable& liveParameters();  ///< with those of the core

/// Both throw std::invalid_argument with a sentence that names the parameter, its value and what is accepted.
Parameters readParameters(const ros::NodeHandle& pnh);
RuntimeOptions readRuntimeOptions(const ros::NodeHandle& pnh, const Parameters& at_start);

/// "~input stream, ~scale unit, ~features 1000": the choices that decide what is published, and every parameter that is
/// not at its default, be it left by an earlier launch.
std::string settingsText(const ros::NodeHandle& pnh);

/// A sentence for each parameter set in the private namespace that neither the node nor its image transports know, or
/// that the other parameters leave without a use.
std::vector<std::string> parametersWithoutEffect(const ros::NodeHandle& pnh, const Parameters& parameters);

}  // namespace gms_ransac
