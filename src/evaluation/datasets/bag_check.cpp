#include "datasets/bag_check.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include <rosbag/constants.h>

#include "datasets/dataset.h"

namespace gms_ransac {

namespace {

// rosbag closes a chunk at 768 kB by default, or behind the one message that is larger.
constexpr uint64_t kLargestChunk = uint64_t{1} << 30;

constexpr uint64_t kNoIndex = 0;  // of a bag whose recorder did not end in peace

using Places = std::set<uint64_t>;  // bytes from the beginning

struct Record {
  uint64_t begin = 0;
  uint64_t data = 0;  ///< where it begins
  uint64_t end = 0;
  std::map<std::string, std::string> header;

  uint8_t kind() const {
    const auto op = header.find(rosbag::OP_FIELD_NAME);
    return op == header.end() || op->second.size() != 1 ? 0 : static_cast<uint8_t>(op->second[0]);
  }
  /// A number of the header; zero when there is none of that name and size.
  template <typename Number>
  Number number(const std::string& name) const {
    Number value = 0;
    const auto field = header.find(name);
    if (field != header.end() && field->second.size() == sizeof(value)) {
      std::memcpy(&value, field->second.data(), sizeof(value));
    }
    return value;
  }
};

class BagWalk {
 public:
  explicit BagWalk(const std::string& file)
      : file_(file), stream_(file, std::ios::binary), size_(std::filesystem::file_size(file)) {}

  void check() {
    std::string version;
    std::getline(stream_, version);
    if (version != "#ROSBAG V2.0") return;
    for (uint64_t at = version.size() + 1; at < size_;) at = checkRecord(at);
    for (const uint64_t place : index_) {
      if (place == kNoIndex) continue;  // rosbag says so
      if (records_.count(place) == 0 && place != size_) fail(place, "the index should be here, and no record begins");
    }
    for (const uint64_t place : named_chunks_) {
      if (chunks_.count(place) == 0) fail(place, "a chunk should be here, and none begins");
    }
  }

 private:
  [[noreturn]] void fail(uint64_t at, const std::string& what) const {
    throw DatasetError(file_ + ": cannot be read as a bag (byte " + std::to_string(at) + ": " + what + ")");
  }

  uint32_t lengthAt(uint64_t at, uint64_t end) {
    uint32_t length = 0;
    if (end - at < sizeof(length)) fail(at, "it ends amid a record");
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(reinterpret_cast<char*>(&length), sizeof(length));
    if (length > end - at - sizeof(length)) {
      fail(at, "a length of " + std::to_string(length) + " bytes, and " + std::to_string(end - at - sizeof(length)) +
                   " are left");
    }
    return length;
  }

  /// `end`: of the file, or of the chunk around it.
  Record recordAt(uint64_t at, uint64_t end) {
    Record record;
    record.begin = at;
    const uint32_t header_length = lengthAt(at, end);
    std::string bytes(header_length, '\0');
    stream_.read(bytes.data(), header_length);
    for (size_t field = 0; field + sizeof(uint32_t) <= bytes.size();) {
      uint32_t length = 0;
      std::memcpy(&length, bytes.data() + field, sizeof(length));
      field += sizeof(length);
      if (length > bytes.size() - field) fail(at, "a field that is longer than its header");
      const size_t equals = bytes.find(static_cast<char>(rosbag::FIELD_DELIM), field);
      if (equals >= field + length) fail(at, "a field without a name");
      record.header[bytes.substr(field, equals - field)] = bytes.substr(equals + 1, field + length - equals - 1);
      field += length;
    }
    const uint64_t length_of_data = at + sizeof(uint32_t) + header_length;
    record.data = length_of_data + sizeof(uint32_t);
    record.end = record.data + lengthAt(length_of_data, end);
    return record;
  }

  uint64_t checkRecord(uint64_t at) {
    const Record record = recordAt(at, size_);
    records_.insert(at);
    switch (record.kind()) {
      case rosbag::OP_FILE_HEADER:
        index_.insert(record.number<uint64_t>(rosbag::INDEX_POS_FIELD_NAME));
        break;
      case rosbag::OP_CHUNK:
        chunks_.insert(at);
        checkChunk(record);
        break;
      case rosbag::OP_INDEX_DATA:
        checkEntries(record);
        break;
      case rosbag::OP_CHUNK_INFO:
        named_chunks_.insert(record.number<uint64_t>(rosbag::CHUNK_POS_FIELD_NAME));
        break;
      default:
        break;
    }
    return record.end;
  }

  void checkChunk(const Record& chunk) {
    const auto unpacked = chunk.number<uint32_t>(rosbag::SIZE_FIELD_NAME);
    if (unpacked > kLargestChunk) {
      fail(chunk.begin, "a chunk that claims to unpack to " + std::to_string(unpacked) + " bytes");
    }
    messages_.clear();
    const auto compression = chunk.header.find(rosbag::COMPRESSION_FIELD_NAME);
    looked_into_ = compression != chunk.header.end() && compression->second == rosbag::COMPRESSION_NONE;
    if (!looked_into_) return;
    for (uint64_t at = chunk.data; at < chunk.end;) {
      messages_.insert(at - chunk.data);
      at = recordAt(at, chunk.end).end;
    }
  }

  /// The entries of the index that follow their chunk: a time of eight bytes and a place in the chunk of four each.
  void checkEntries(const Record& entries) {
    constexpr uint64_t kTimeBytes = 8, kPlaceBytes = 4;
    if (!looked_into_) return;
    for (uint64_t at = entries.data; at + kTimeBytes + kPlaceBytes <= entries.end; at += kTimeBytes + kPlaceBytes) {
      uint32_t place = 0;
      stream_.seekg(static_cast<std::streamoff>(at + kTimeBytes));
      stream_.read(reinterpret_cast<char*>(&place), sizeof(place));
      if (messages_.count(place) == 0) fail(at, "an entry of the index that points at no message");
    }
  }

  const std::string file_;
  std::ifstream stream_;
  const uint64_t size_;
  Places records_, chunks_, index_, named_chunks_;
  Places messages_;  ///< of the last chunk, from its data on
  bool looked_into_ = false;
};

}  // namespace

void checkBag(const std::string& file) { BagWalk(file).check(); }

}  // namespace gms_ransac
