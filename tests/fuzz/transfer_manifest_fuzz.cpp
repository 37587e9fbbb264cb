#include "patinate/transfer/transfer_io.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(transfer_manifest) {
  const auto file = fuzz::fuzz_file("transfer.json", bytes);
  (void)transfer::read_transfer_manifest(file.parent_path());
}
