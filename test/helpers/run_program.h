// Runs a command of the shell.
#pragma once

#include <cstdio>
#include <string>

#include <sys/wait.h>

namespace gms_ransac {

struct Outcome {
  int status = -1;
  std::string text;  ///< standard output and error
};

inline Outcome run(const std::string& command) {
  Outcome outcome;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char buffer[4096];
  while (std::fgets(buffer, sizeof(buffer), pipe)) outcome.text += buffer;
  outcome.status = WEXITSTATUS(pclose(pipe));
  return outcome;
}

}  // namespace gms_ransac
