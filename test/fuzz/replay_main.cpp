// The main function of a fuzz target where there is no libFuzzer.
//   fuzz_TARGET FILE_OR_FOLDER...            each file once
//   fuzz_TARGET --random SECONDS SEED [FILE_OR_FOLDER...]
//       random inputs and random changes of the files; the one that ends the process is in ./found_TARGET_SEED
#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "random.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using Bytes = std::vector<uint8_t>;

Bytes current;
std::string left_in;

void keepInput(int signal) {
  const int file = open(left_in.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && write(file, current.data(), current.size()) >= 0) close(file);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

std::vector<std::string> filesOf(const std::vector<std::string>& arguments) {
  std::vector<std::string> files;
  for (const std::string& argument : arguments) {
    if (!std::filesystem::is_directory(argument)) {
      files.push_back(argument);
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(argument)) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Bytes contentOf(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    std::fprintf(stderr, "%s cannot be read\n", file.c_str());
    std::exit(1);
  }
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

Bytes randomInput(gms_ransac::Random& random, const std::vector<Bytes>& seeds) {
  constexpr int kLongest = 1000, kMostChanges = 20;
  Bytes input;
  if (seeds.empty() || random.below(2) == 0) {
    input.resize(static_cast<size_t>(random.below(kLongest)));
    for (uint8_t& byte : input) byte = static_cast<uint8_t>(random.next());
    return input;
  }
  input = seeds[static_cast<size_t>(random.below(static_cast<int>(seeds.size())))];
  for (int n = random.below(kMostChanges); n > 0 && !input.empty(); --n) {
    const auto at = static_cast<size_t>(random.below(static_cast<int>(input.size())));
    const int change = random.below(8);
    if (change == 0) {
      input.erase(input.begin() + static_cast<std::ptrdiff_t>(at));
    } else if (change == 1) {
      input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), static_cast<uint8_t>(random.next()));
    } else if (change == 2) {
      input[at] = static_cast<uint8_t>(input[at] ^ (1 << random.below(8)));
    } else {
      input[at] = static_cast<uint8_t>(random.next());
    }
  }
  return input;
}

/// The buffer has exactly the input's size, so that a sanitizer sees a read beyond it.
void runCurrent() { LLVMFuzzerTestOneInput(current.data(), current.size()); }

void runRandomly(const std::string& name, double seconds, uint64_t seed, const std::vector<std::string>& files) {
  left_in = "found_" + name + "_" + std::to_string(seed);
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, keepInput);
  std::vector<Bytes> seeds;
  for (const std::string& file : files) seeds.push_back(contentOf(file));
  gms_ransac::Random random(seed);
  int64_t runs = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (; std::chrono::steady_clock::now() < end; ++runs) {
    current = randomInput(random, seeds);
    runCurrent();
  }
  std::printf("%lld random inputs\n", static_cast<long long>(runs));
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() >= 3 && arguments[0] == "--random") {
    const std::string name = std::filesystem::path(argv[0]).filename().string();
    runRandomly(name, std::stod(arguments[1]), std::stoull(arguments[2]),
                filesOf({arguments.begin() + 3, arguments.end()}));
    return 0;
  }
  const std::vector<std::string> files = filesOf(arguments);
  for (const std::string& file : files) {
    std::fprintf(stderr, "%s\n", file.c_str());
    current = contentOf(file);
    runCurrent();
  }
  std::printf("%zu inputs replayed\n", files.size());
  return files.empty() ? 1 : 0;
}
