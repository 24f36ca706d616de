// Brute force on transposed train descriptors, one per byte lane: the walk over blocks and the bookkeeping that every
// vector kernel shares. A kernel supplies vectors, tables and distances as `Isa`, a type of its file's own.
//
// Distances are bytes that saturate at 255. The vectors of lanes of a block are reduced to their minimum before the
// running best, second best and block index are updated, so this costs little compared with the bit counting. The
// vector of the minimum is found once per query from the exact distances. Train descriptor i is in block i / kBlock,
// lane (i % kBlock) / kVectors, vector i % kVectors: so the order (block, lane, vector) is that of the indices, and
// ties go to the lowest.
#pragma once

#include <algorithm>
#include <cstring>

#include "matching/hamming_kernels.h"

namespace gms_ransac {
namespace {

constexpr int kQueryGroup = 8;            ///< queries compared with a block while it is in the nearest cache
constexpr int kIndexRange = 256;          ///< block numbers are bytes; longer inputs are cut into runs of so many
constexpr int kExactDistanceLimit = 255;  ///< bytes cannot tell 255 from 256

alignas(64) constexpr uint8_t kLaneNumbers[64] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                                  16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31,
                                                  32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 43, 44, 45, 46, 47,
                                                  48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63};

/// 255 in the lanes of one vector of a block with `left` descriptors that hold none.
template <class Isa>
typename Isa::Vector paddingLanes(int vector, int left) {
  alignas(64) uint8_t padding[Isa::kLanes];
  for (int lane = 0; lane < Isa::kLanes; ++lane) padding[lane] = lane * Isa::kVectors + vector >= left ? 255 : 0;
  return Isa::load(padding);
}

template <class Isa>
struct Blocked {
  using Vector = typename Isa::Vector;
  static constexpr int kLanes = Isa::kLanes;
  static constexpr int kVectors = Isa::kVectors;
  static constexpr int kBlock = kVectors * kLanes;

  static int blocks(int train_count) { return (train_count + kBlock - 1) / kBlock; }
  static size_t packedBytes(int train_count) { return static_cast<size_t>(blocks(train_count)) * Isa::kBlockBytes; }

  /// Running minima of one query over the blocks of a run, per lane.
  struct alignas(64) Running {
    uint8_t best[kLanes], second[kLanes], block[kLanes];
  };

  static void pack(const uint8_t* rows, int count, uint8_t* packed) {
    for (int block = 0; block < blocks(count); ++block) {
      const int first = block * kBlock;
      Isa::packBlock(rows + static_cast<size_t>(first) * kHammingBytes, std::min(kBlock, count - first),
                     packed + static_cast<size_t>(block) * Isa::kBlockBytes);
    }
  }

  /// The lane of the least (distance, block, lane); `second`: the least distance of its other blocks and other lanes.
  static int nearestLane(const Running& running, int& second) {
    const Vector none = Isa::broadcast(255), numbers = Isa::load(kLaneNumbers), bests = Isa::load(running.best);
    const Vector best = Isa::broadcast(Isa::smallestByte(bests));
    const Vector blocks = Isa::selectLess(best, bests, none, Isa::load(running.block));
    const Vector block = Isa::broadcast(Isa::smallestByte(blocks));
    const Vector tied = Isa::selectLess(best, bests, none, numbers);
    const int lane = Isa::smallestByte(Isa::selectLess(block, blocks, none, tied));
    const Vector own = Isa::broadcast(lane);
    const Vector others = Isa::selectLess(own, numbers, bests, Isa::selectLess(numbers, own, bests, none));
    second = std::min(Isa::smallestByte(others), static_cast<int>(running.second[lane]));
    return lane;
  }

  /// The descriptor in (run, block, lane) that is nearest is one of kVectors: finds it and merges it into `nearest`.
  static void mergeRow(const HammingSearch& search, int query, const Running& running, int run_first,
                       NearestTwo& nearest) {
    const uint8_t* row = search.queries + static_cast<size_t>(query) * kHammingBytes;
    int second;
    const int lane = nearestLane(running, second), best = running.best[lane];
    if (std::max(best, second) >= kExactDistanceLimit) {
      // Saturated (or fewer than two descriptors): every distance again, exactly. Real descriptors never come here.
      const int run_last = std::min(search.train_count, run_first + kIndexRange * kBlock);
      for (int j = run_first; j < run_last; ++j) {
        mergeOne(hammingDistance(row, search.train + static_cast<size_t>(j) * kHammingBytes), j, nearest);
      }
      return;
    }
    const int first = run_first + running.block[lane] * kBlock + lane * kVectors;
    // Distance and place in one number, sorted without branches: which of them it is cannot be predicted.
    int nearest_key = kNoDistance * kVectors, second_key = nearest_key;
    for (int k = 0; k < kVectors; ++k) {
      const int j = std::min(first + k, search.train_count - 1);
      int key = hammingDistance(row, search.train + static_cast<size_t>(j) * kHammingBytes) * kVectors + k;
      if (first + k != j) key = kNoDistance * kVectors;
      second_key = std::min(second_key, std::max(nearest_key, key));
      nearest_key = std::min(nearest_key, key);
    }
    mergeOne(nearest_key / kVectors, first + nearest_key % kVectors, nearest);
    second = std::min(second, second_key / kVectors);
    nearest.second_distance = std::min(nearest.second_distance, static_cast<uint16_t>(second));
  }

  static void mergeOne(int distance, int index, NearestTwo& nearest) {
    if (distance < nearest.distance) {
      nearest.second_distance = nearest.distance;
      nearest.distance = static_cast<uint16_t>(distance);
      nearest.index = index;
    } else if (distance < nearest.second_distance) {
      nearest.second_distance = static_cast<uint16_t>(distance);
    }
  }

  struct Tile {
    typename Isa::Tables tables[Isa::kTileGroups];
    Running running[Isa::kTileGroups * kQueryGroup];
  };

  /// Up to Isa::kTileGroups groups of queries against one run of blocks.
  static void searchTile(const HammingSearch& search, int first_query, int last_query, int run_first) {
    Tile tile;
    const int tile_groups = (last_query - first_query + kQueryGroup - 1) / kQueryGroup;
    const auto query = [&](int q) {  // a group that is not full repeats its last query
      return search.queries + static_cast<size_t>(std::min(first_query + q, last_query - 1)) * kHammingBytes;
    };
    for (int g = 0; g < tile_groups; ++g) {
      for (int pair = 0; pair < kQueryGroup / 2; ++pair) {
        const int q = g * kQueryGroup + 2 * pair;
        Isa::setQueries(tile.tables[g], pair, query(q), query(q + 1));
      }
    }
    std::memset(tile.running, 255, sizeof(Running) * tile_groups * kQueryGroup);

    const int first_block = run_first / kBlock;
    const int last_block = std::min(blocks(search.train_count), first_block + kIndexRange);
    for (int block = first_block; block < last_block; ++block) {
      const int left = search.train_count - block * kBlock;
      const uint8_t* packed = search.packed_train + static_cast<size_t>(block) * Isa::kBlockBytes;
      const Vector number = Isa::broadcast(block - first_block);
      for (int g = 0; g < tile_groups; ++g) {
        Vector block_minimum[kQueryGroup];
        Isa::distances(tile.tables[g], packed, left, block_minimum);
        Running* running = tile.running + g * kQueryGroup;
        for (int q = 0; q < kQueryGroup; ++q) {
          const Vector old_best = Isa::load(running[q].best);
          const Vector old_second = Isa::load(running[q].second);
          Isa::store(running[q].block,
                     Isa::selectLess(block_minimum[q], old_best, number, Isa::load(running[q].block)));
          Isa::store(running[q].best, Isa::min(old_best, block_minimum[q]));
          Isa::store(running[q].second, Isa::min(old_second, Isa::max(old_best, block_minimum[q])));
        }
      }
    }
    for (int q = 0; q < last_query - first_query; ++q) {
      mergeRow(search, first_query + q, tile.running[q], run_first, search.nearest[first_query + q]);
    }
  }

  static void search(const HammingSearch& search) {
    std::fill_n(search.nearest, search.query_count, NearestTwo());
    constexpr int kTile = Isa::kTileGroups * kQueryGroup;
    for (int run = 0; run < search.train_count; run += kIndexRange * kBlock) {
      for (int query = 0; query < search.query_count; query += kTile) {
        searchTile(search, query, std::min(query + kTile, search.query_count), run);
      }
    }
  }

  static constexpr HammingKernel kernel(
      decltype(HammingKernel::searchRuns) searchRuns = searchRunsRowwise<const int32_t*>) {
    return {packedBytes, pack, search, searchRuns};
  }
};

}  // namespace
}  // namespace gms_ransac
