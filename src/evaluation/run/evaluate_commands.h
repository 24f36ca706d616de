// The subcommands of `evaluate`. Each takes the arguments behind its name and returns the exit status; bad input is an
// exception with one clear sentence.
#pragma once

#include "command_line.h"

namespace gms_ransac {

int evaluateRun(const Arguments& arguments);
int evaluateSweep(const Arguments& arguments);
int evaluateTables(const Arguments& arguments);
int evaluateTrust(const Arguments& arguments);
int evaluateMerge(const Arguments& arguments);

}  // namespace gms_ransac
