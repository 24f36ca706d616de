// An exception that leaves a callback or a worker ends the process, and with it every nodelet of the manager.
#pragma once

#include <exception>
#include <string>

namespace gms_ransac {

/// Runs `work`; what it throws goes to `report` in words.
template <typename Work, typename Report>
void guarded(const Work& work, const Report& report) {
  try {
    work();
  } catch (const std::exception& error) {
    report(std::string(error.what()));
  } catch (...) {  // XmlRpcException, for one, is no std::exception
    report(std::string("an exception of unknown type"));
  }
}

}  // namespace gms_ransac
