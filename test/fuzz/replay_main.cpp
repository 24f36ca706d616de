// The main function of a fuzz target where there is no libFuzzer: fuzz_TARGET [FILE...] runs an empty input,
// random ones, and each file once.
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

/// `input` has exactly its size, so that a sanitizer sees a read beyond it.
static void run(const char* name, const std::vector<uint8_t>& input) {
  std::fprintf(stderr, "%s, %zu bytes\n", name, input.size());
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

int main(int argc, char** argv) {
  std::mt19937 random(1);
  for (size_t size = 0; size <= 1500; size += 50) {
    std::vector<uint8_t> input(size);
    for (uint8_t& byte : input) byte = static_cast<uint8_t>(random());
    run("random", input);
  }
  for (int i = 1; i < argc; ++i) {
    std::ifstream stream(argv[i], std::ios::binary);
    if (!stream) return 1;
    run(argv[i], {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()});
  }
}
