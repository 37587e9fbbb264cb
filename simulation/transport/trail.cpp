#include "simulation/transport/trail.h"

#include "libcommon/core/parallel.h"

namespace patinate::simulation {

void follow(std::span<const Contact> contacts, std::vector<Trail>& trails, const RunControl& control) {
  constexpr std::int64_t kChunk = 32768;
  RunControl threads;  // half of them are no state to stop in
  threads.num_threads = control.num_threads;
  parallel_for(static_cast<std::int64_t>(contacts.size()), kChunk, threads, [&](std::int64_t begin, std::int64_t end) {
    for (const Contact& contact :
         contacts.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin))) {
      Trail& trail = trails[contact.gammaton];
      if (contact.is_landing) trail.clear();
      trail.add(contact.texel);
    }
  });
}

}  // namespace patinate::simulation
