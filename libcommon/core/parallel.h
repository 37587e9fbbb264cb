/// \file
/// Ordered parallel loops: results never depend on the number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "patinate/core/run_control.h"

namespace patinate {

/// Threads that `control` asks for, >= 1.
[[nodiscard]] int thread_count(const RunControl& control);

/// Calls body(begin, end) once for each chunk [k * chunk_size, min(n, (k + 1) * chunk_size)) of [0, n), in any order,
/// on several threads. Chunks do not depend on the number of threads.
/// @param chunk_size  > 0; about 1-20 ms of work, since `control.stop` is looked at between chunks.
/// @throws Canceled after stop; the first exception (lowest chunk) that a body threw.
void parallel_for(std::int64_t n, std::int64_t chunk_size, const RunControl& control,
                  const std::function<void(std::int64_t begin, std::int64_t end)>& body);

/// combine(...combine(combine(init, map(chunk 0)), map(chunk 1))...): fixed chunks, reduced in index order.
template <class T, class Map, class Combine>
[[nodiscard]] T parallel_reduce(std::int64_t n, std::int64_t chunk_size, const RunControl& control, T init, Map&& map,
                                Combine&& combine) {
  const std::int64_t num_chunks = n > 0 ? (n + chunk_size - 1) / chunk_size : 0;
  std::vector<T> partial(static_cast<std::size_t>(num_chunks), init);
  parallel_for(n, chunk_size, control,
               [&](std::int64_t begin, std::int64_t end) { partial[begin / chunk_size] = map(begin, end); });
  T result = std::move(init);
  for (T& p : partial) result = combine(std::move(result), std::move(p));
  return result;
}

}  // namespace patinate
