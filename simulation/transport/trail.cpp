#include "simulation/transport/trail.h"

namespace patinate::simulation {

void follow(std::span<const Contact> contacts, std::vector<Trail>& trails) {
  for (const Contact& contact : contacts) {
    Trail& trail = trails[contact.gammaton];
    if (contact.is_landing) trail.clear();
    trail.add(contact.texel);
  }
}

}  // namespace patinate::simulation
